"""A line with what people changed in it: files of edits and of corrections, one over the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.animation.carry import carry_edits
from phonanim.animation.correction_file import is_corrections, read_corrections
from phonanim.animation.corrections import Corrections
from phonanim.animation.edit_file import read_edits
from phonanim.animation.edits import Edits, apply_edits, moved_edit
from phonanim.core.files import content_hash
from phonanim.errors import OptionError
from phonanim.options import DEFAULTS, Options
from phonanim.pipeline import UNCORRECTED, AnimationResult, animate_detailed, load_cached_rig
from phonanim.rig import Rig
from phonanim.rig.read import rig_names
from phonanim.rig.retarget import limit_sum
from phonanim.speech.anchors import match_phones
from phonanim.speech.intervals import Interval


def animate_corrected(
    path: Path, options: Options = DEFAULTS, audio: Path | None = None, files: Sequence[Path] = ()
) -> AnimationResult:
    """`animate_detailed` with files of edits, in order, and at most one of corrections, which comes last.

    Raises OptionError when a file cannot be read as one of these.
    """
    corrected = [file for file in files if is_corrections(file)]
    if len(corrected) > 1:
        raise OptionError(
            f"{corrected[1]}: a line has one file of corrections, and {corrected[0]} is one, too"
        )
    corrections = read_corrections(corrected[0]) if corrected else UNCORRECTED
    edits = [read_edits(file) for file in files if file not in corrected]
    result = animate_edited(path, options, audio, edits, corrections)
    if not files:
        return result
    hashes = {"edits_sha256": [content_hash(file) for file in files]}
    animation = replace(result.animation, provenance={**result.animation.provenance, **hashes})
    return replace(result, animation=animation)


def animate_edited(
    path: Path,
    options: Options = DEFAULTS,
    audio: Path | None = None,
    edits: Sequence[Edits] = (),
    corrections: Corrections = UNCORRECTED,
) -> AnimationResult:
    """`animate_detailed` with edits, in order, and corrections, whose curves come last."""
    result = animate_detailed(path, options, audio, corrections)
    animation = result.animation
    for one in (*edits, *filter(None, [corrections.curves])):
        animation = apply_line_edits(animation, one, options, result.read)
    if animation is result.animation:
        return result
    return replace(result, animation=animation, notes=tuple(animation.provenance["notes"]))


def apply_line_edits(
    animation: Animation, edits: Edits, options: Options = DEFAULTS, read: tuple[Interval, ...] = ()
) -> Animation:
    """The animation with edits applied; `provenance["notes"]` lists those that did not fit.

    Edits of another rig are carried to this one. `read` are the phones before they were corrected.
    """
    rig = load_cached_rig(options.rig)
    made_on = edits.rig
    edits, carried = _carried_to(rig, edits)
    edited, notes = apply_edits(animation, edits, rig, read)
    if edits.rig != made_on:
        edited = edited.with_values(limit_sum(edited.values, edited.channels, rig))
    told = {"notes": [*animation.provenance["notes"], *carried, *notes]}
    return replace(edited, provenance={**animation.provenance, **told})


def join_edits(every: Sequence[Edits]) -> tuple[Edits, tuple[str, ...]]:
    """Edits of one line as edits of the rig and the phones of the first, and notes on what was left out."""
    first, *others = every
    found = list(first.edits)
    notes: list[str] = []
    for one in others:
        if first.rig in rig_names():
            one, carried = _carried_to(load_cached_rig(first.rig), one)
            notes += carried
        anchors = match_phones(one.phones, first.phones)
        found += [moved_edit(edit, anchors) for edit in one.edits]
    error = max(one.error for one in every)
    return replace(first, error=error, edits=tuple(found)), tuple(notes)


def _carried_to(rig: Rig, edits: Edits) -> tuple[Edits, tuple[str, ...]]:
    """Edits as those of a rig, and notes, where the rig that they were made on is known."""
    if edits.rig == rig.name or edits.rig not in rig_names():
        return edits, ()
    return carry_edits(edits, load_cached_rig(edits.rig), rig)
