"""Score motion against a reference: all measures that both sides allow.

The steps: resample both sides at the same instants, compare controls by name, put both on a mesh if possible,
compare vertices by region, compare lips as curves, group errors by phone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.errors import EvaluationError
from phonanim.evaluation.channels import CHANNEL_OF, articulation_of, channel_error, channel_measures
from phonanim.evaluation.legibility import VisemeRow, viseme_scores
from phonanim.evaluation.measures import (
    control_measures,
    control_regions,
    find_rest,
    lip_measures,
    vertex_measures,
)
from phonanim.evaluation.predictions import Motion, resample_motion
from phonanim.evaluation.surfaces import Settings, Surface, make_surface, moves_head
from phonanim.evaluation.upper_face import upper_face_measures
from phonanim.metrics import (
    PhoneError,
    by_class,
    by_phone,
    control_diversity,
    diversity,
    mean_vertex_error,
    speech_mask,
    squared_error,
)
from phonanim.rig.morphs import plain_name
from phonanim.rig.neck import TURNS

Array = NDArray[np.float64]
FEWEST = 4  # frames; fewer have no spectrum and no jerk
STRANGERS = 10.0  # mm between mean faces: more is not an error of speech, but another head or another unit


@dataclass(frozen=True)
class Scores:
    """Measures by name; the measure `error` by phone and class of phones; visemes read; and notes."""

    measures: dict[str, float]
    frames: int
    fps: float
    error: str
    phones: tuple[PhoneError, ...] = ()
    classes: tuple[PhoneError, ...] = ()
    notes: tuple[str, ...] = ()
    visemes: tuple[VisemeRow, ...] = ()


@dataclass
class _Found:
    """What has been measured so far: per-frame `errors` in the order of their precedence, last first."""

    measures: dict[str, float]
    errors: dict[str, Array]
    notes: list[str]
    visemes: tuple[VisemeRow, ...] = ()


def score(predicted: Motion, captured: Motion, settings: Settings) -> Scores:
    """Every measure that the two sides allow.

    Raises EvaluationError when they share no instants, no controls, no mesh and no articulation.
    """
    predicted, captured, notes = match_instants(predicted, captured)
    found = _Found({}, {}, notes)
    mouth, wanted, said = match_articulation(predicted, captured, settings)
    if wanted:
        found.measures |= channel_measures(mouth, wanted, said)
        found.errors["articulation_error_mm"] = channel_error(mouth, wanted, said)
    for compare in (_compare_controls, _compare_surfaces):
        try:
            compare(predicted, captured, settings, found)
        except EvaluationError as trouble:
            if not wanted:
                raise
            found.notes.append(f"articulation is scored, other measures are not: {trouble}")
    if not found.errors:
        raise EvaluationError(
            "controls can be compared only with vertices of the package's head, and this is another mesh; "
            "give both as controls or both as vertices"
        )
    name, error = list(found.errors.items())[-1]
    phones, classes = (
        tuple(table(error, captured.times, settings.track)) if settings.track else ()
        for table in (by_phone, by_class)
    )
    told = tuple(found.notes)
    return Scores(found.measures, len(error), captured.fps, name, phones, classes, told, found.visemes)


def _compare_controls(predicted: Motion, captured: Motion, settings: Settings, found: _Found) -> None:
    """Add the measures of curves, where both sides are curves."""
    if not isinstance(predicted, Animation) or not isinstance(captured, Animation):
        return
    upper = upper_face_measures(predicted)
    upper |= {f"captured_{name}": value for name, value in upper_face_measures(captured).items()}
    predicted, captured, remarks = match_channels(without_turns(predicted), without_turns(captured))
    own = {} if moves_head(predicted) and moves_head(captured) else settings.masks
    regions = control_regions(captured.channels, own)
    found.measures |= control_measures(predicted, captured, regions) | upper
    if settings.template is not None:
        found.notes.append("the template is not used: it is the rest of vertices, and these are controls")
    found.errors["control_mse"] = squared_error(predicted.values, captured.values)
    found.notes += remarks


def _compare_surfaces(predicted: Motion, captured: Motion, settings: Settings, found: _Found) -> None:
    """Add the measures of vertices and lips, where both sides move one mesh."""
    if isinstance(predicted, Animation) and isinstance(captured, Animation):
        predicted, captured, _ = match_channels(without_turns(predicted), without_turns(captured))
    surfaces = match_surfaces(predicted, captured, settings)
    if not surfaces:
        return
    ours, theirs = surfaces
    found.measures |= vertex_measures(ours, theirs, captured.fps)
    if theirs.lips:
        lips = ours.lips, theirs.lips, captured.times
        found.measures |= lip_measures(*lips, captured.fps, settings.track)
        if settings.track is not None:
            legible, found.visemes = viseme_scores(*lips, settings.track)
            found.measures |= legible
    rows = ours.masks.get("lips", np.arange(ours.points.shape[1]))
    error = mean_vertex_error(ours.points, theirs.points, rows)
    found.errors["tmve_lips_mm" if "lips" in ours.masks else "mve_mm"] = error
    found.notes += [*theirs.notes, *find_doubts(ours, theirs)]


def match_articulation(
    predicted: Motion, captured: Motion, settings: Settings
) -> tuple[dict[str, Array], dict[str, Array], NDArray[np.bool_]]:
    """The channels of articulation of both sides, and a mask of speech (frames,), or of all frames.

    Captured lips stand for the channels that they show. Nothing is wanted where the prediction has none.
    """
    mouth, wanted = (articulation_of(m) if isinstance(m, Animation) else {} for m in (predicted, captured))
    if mouth and not wanted:
        rest = settings.template if settings.reference_template is None else settings.reference_template
        surface = make_surface(captured, settings, rest)
        lips = surface.lips if surface is not None else {}
        wanted = {CHANNEL_OF[name]: curve for name, curve in lips.items()}
    said = np.ones(len(captured.times), bool)
    if settings.track is not None and speech_mask(settings.track, captured.times).any():
        said = speech_mask(settings.track, captured.times)
    return mouth, {name: curve for name, curve in wanted.items() if name in mouth}, said


def match_instants(predicted: Motion, captured: Motion) -> tuple[Motion, Motion, list[str]]:
    """Both sides at the reference's instants that both have. Raises EvaluationError when they are too few."""
    ends = [float(motion.times[-1]) for motion in (predicted, captured)]
    first, slack = max(predicted.start, captured.start), 0.5 / captured.fps
    times = captured.times
    kept = times[(times >= first - slack) & (times <= min(ends) + slack)]
    if len(kept) < FEWEST:
        raise EvaluationError(
            f"predictions from {predicted.start:g} to {ends[0]:g} s and a reference from {captured.start:g} "
            f"to {ends[1]:g} s share {len(kept)} frames; {FEWEST} are needed"
        )
    notes = []
    if not np.isclose(predicted.fps, captured.fps):
        notes.append(f"predictions at {predicted.fps:g} fps, resampled at the reference's {captured.fps:g}")
    if abs(ends[0] - ends[1]) > slack or not np.isclose(predicted.start, captured.start):
        notes.append(
            f"predictions {predicted.start:.3f} to {ends[0]:.3f} s, reference {captured.start:.3f} to "
            f"{ends[1]:.3f} s: scored from {kept[0]:.3f} to {kept[-1]:.3f} s"
        )
    return resample_motion(predicted, kept), resample_motion(captured, kept), notes


def without_turns(animation: Animation) -> Animation:
    """The animation without the turns of its head, which are degrees and no weights."""
    turns = set(map(plain_name, TURNS))
    kept = [i for i, name in enumerate(animation.channels) if plain_name(name) not in turns]
    channels = tuple(animation.channels[i] for i in kept)
    return replace(animation, values=animation.values[:, kept], channels=channels)


def match_channels(predicted: Animation, captured: Animation) -> tuple[Animation, Animation, list[str]]:
    """Both with the reference's channels, by name; channels that the predictions lack are 0.

    Raises EvaluationError when no name is equal, or, for controls without names, when their number differs.
    """
    if not predicted.rig and not captured.rig and len(predicted.channels) != len(captured.channels):
        raise EvaluationError(
            f"the predictions have shape {predicted.values.shape}, the reference {captured.values.shape}; "
            "controls without names must have the same number on both sides"
        )
    own = {plain_name(name): row for row, name in enumerate(predicted.channels)}
    theirs = [plain_name(name) for name in captured.channels]
    if not own.keys() & set(theirs):
        raise EvaluationError(
            f"no control in common: the predictions have {_some(predicted.channels)}, the reference "
            f"{_some(captured.channels)}; bring both to one rig"
        )
    values = np.zeros_like(captured.values)
    shared = [column for column, name in enumerate(theirs) if name in own]
    values[:, shared] = predicted.values[:, [own[theirs[column]] for column in shared]]
    lacking = [name for name in captured.channels if plain_name(name) not in own]
    extra = [name for name in predicted.channels if plain_name(name) not in theirs]
    notes = [f"controls that the predictions lack count as zero: {_some(lacking)}"] if lacking else []
    notes += [f"controls that the reference lacks are left out: {_some(extra)}"] if extra else []
    return replace(predicted, values=values, channels=captured.channels), captured, notes


def match_surfaces(predicted: Motion, captured: Motion, settings: Settings) -> tuple[Surface, Surface] | None:
    """Both sides on one mesh; None if that is impossible. Raises EvaluationError for different meshes.

    If both have a template, each motion is taken relative to its template and put on the reference's.
    """
    theirs_at_rest = settings.template if settings.reference_template is None else settings.reference_template
    ours = make_surface(predicted, settings, settings.template)
    theirs = make_surface(captured, settings, theirs_at_rest)
    if ours is None or theirs is None:
        return None
    if ours.points.shape != theirs.points.shape:
        raise EvaluationError(
            f"the predictions have shape {ours.points.shape}, the reference {theirs.points.shape} "
            "(frames, vertices, 3); they are of different meshes"
        )
    if ours.rest is not None and theirs.rest is not None:
        ours = replace(ours, points=ours.points - ours.rest + theirs.rest, rest=theirs.rest)
    return ours, theirs


def takes_diversity(takes: Sequence[Motion], settings: Settings) -> dict[str, float]:
    """Diversity of several takes of one line over their common frames, by name; the user's regions too.

    `diversity_mm` of a mesh, `control_diversity` of controls; empty where takes differ in kind.
    """
    curves = [without_turns(take) for take in takes if isinstance(take, Animation)]
    found = {}
    if len(curves) == len(takes) and len({take.channels for take in curves}) == 1:
        frames = min(len(take.values) for take in curves)
        values = np.stack([take.values[:frames] for take in curves])
        found["control_diversity"] = control_diversity(values)
        own = {} if moves_head(curves[0]) else settings.masks
        for name, columns in control_regions(curves[0].channels, own).items():
            found[f"control_diversity_{name}"] = control_diversity(values, columns)
    surfaces = [make_surface(take, settings, settings.template) for take in takes]
    known = [each for each in surfaces if each is not None]
    if len(known) < len(takes) or len({each.points.shape[1] for each in known}) > 1:
        return found
    frames = min(len(each.points) for each in known)
    points = np.stack([each.points[:frames] for each in known])
    found["diversity_mm"] = diversity(points)
    for name in settings.masks:
        found[f"diversity_{name}_mm"] = diversity(points, known[0].masks[name])
    return found


def find_doubts(ours: Surface, theirs: Surface) -> list[str]:
    """Warnings about vertex errors that are meaningless or less exact than they look."""
    apart = float(np.linalg.norm((ours.points - theirs.points).mean(axis=0), axis=1).mean())
    doubts = []
    if apart > STRANGERS:
        doubts.append(
            f"the mean faces are {apart:.0f} mm apart: another head, place or unit? --template and "
            "--reference-template give the rest pose of each side"
        )
    without = find_rest(theirs)[1]
    return [*doubts, without] if without else doubts


def _some(names: tuple[str, ...] | list[str]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
