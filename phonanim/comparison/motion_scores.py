"""Measures of a clip of controls, sensors or vertices, as sums that pool over clips.

A unit of statistics is a clip; of long clips it is a piece of about PIECE seconds, so that a take of some
minutes has an interval, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.comparison.scores import short
from phonanim.corpus.motion import MotionCorpus
from phonanim.errors import EvaluationError
from phonanim.evaluation.corpora import motion_of
from phonanim.evaluation.measures import control_regions
from phonanim.evaluation.statistics import pearson_sums
from phonanim.metrics import distances, euclidean_error, summed_absolute_error
from phonanim.targets.sensors import mouth_channels

Array = NDArray[np.float64]
Chosen = NDArray[np.bool_]
Rows = NDArray[np.int64]
PIECE = 6.0  # seconds
LIVELY = 10  # controls that move most in training, whose curves are compared
MILLIMETRES = {"m": 1000.0, "cm": 10.0, "mm": 1.0}
KINDS = {
    "controls": ("control_l1", "control_l2", "mouth_l2"),
    "sensors": ("channel_error",),
    "vertices": ("mesh_error", "mesh_lip_error"),
}
"""The errors of each kind; r and the sd ratio of its curves stand beside them."""


def curve_names(corpus: MotionCorpus) -> tuple[str, ...]:
    """The curves whose r is measured: controls that move most in training, channels, or all coordinates."""
    if corpus.kind == "vertices":
        return ("all coordinates",)
    if corpus.kind == "sensors":
        return tuple(mouth_channels(np.zeros((1, len(corpus.source.names), 3)), corpus.source.names))
    total, square, count = np.zeros(()), np.zeros(()), 0
    for clip in corpus.clips_of("train"):
        values = np.asarray(corpus.frames(int(clip)), np.float64)
        total, square, count = (
            total + values.sum(axis=0),
            square + (values**2).sum(axis=0),
            count + len(values),
        )
    spread = square / max(count, 1) - (total / max(count, 1)) ** 2
    order = np.argsort(-spread, kind="stable")[:LIVELY]
    names = control_names(corpus, len(spread))
    return tuple(names[int(row)] for row in sorted(order) if spread[row] > 0)


def control_names(corpus: MotionCorpus, count: int) -> tuple[str, ...]:
    """The names of controls, or their numbers."""
    return corpus.source.names or tuple(map(str, range(count)))


def clip_sums(
    predicted: NDArray[np.floating],
    captured: NDArray[np.floating],
    corpus: MotionCorpus,
    clip: int,
    where: Chosen,
    curves: tuple[str, ...],
    masks: Mapping[str, Rows],
) -> list[dict[str, list[float]]]:
    """Sums of every measure over the chosen frames (frames,) of each piece of a clip."""
    frames = {"controls": _control_frames, "sensors": _sensor_frames, "vertices": _vertex_frames}
    errors, pairs = frames[corpus.kind](predicted, captured, corpus, clip, where, curves, masks)
    count = max(1, int(len(where) / corpus.fps / PIECE))
    found = []
    for rows in np.array_split(np.arange(len(where)), count):
        inside = rows[where[rows]]
        sums = {name: np.array([error[inside].sum(), len(inside)]) for name, error in errors.items()}
        sums["curves_r"] = np.concatenate(
            [pearson_sums(a[inside].ravel(), b[inside].ravel()) for a, b in pairs]
        )
        sums["curves_sd_ratio"] = sums["curves_r"]
        found.append({name: short(values) for name, values in sums.items()})
    return found


def _control_frames(
    predicted: NDArray[np.floating], captured: NDArray[np.floating], corpus: MotionCorpus, *rest: Any
) -> tuple[dict[str, Array], list[tuple[Array, Array]]]:
    _, _, curves, masks = rest
    ours, theirs = predicted.astype(np.float64), captured.astype(np.float64)
    names = control_names(corpus, theirs.shape[1])
    errors = {
        "control_l1": summed_absolute_error(ours, theirs),
        "control_l2": euclidean_error(ours, theirs),
    }
    mouth = control_regions(names, masks).get("lips")
    if mouth is not None:
        errors["mouth_l2"] = euclidean_error(ours[:, mouth], theirs[:, mouth])
    rows = [names.index(name) for name in curves]
    return errors, [(ours[:, row], theirs[:, row]) for row in rows]


def _sensor_frames(
    predicted: NDArray[np.floating], captured: NDArray[np.floating], corpus: MotionCorpus, *rest: Any
) -> tuple[dict[str, Array], list[tuple[Array, Array]]]:
    """Channels less their mean in the clip: every recording has its own zero."""
    _, where, curves, _ = rest
    ours, theirs = motion_of(predicted, corpus), motion_of(captured, corpus)
    assert isinstance(ours, Animation)
    assert isinstance(theirs, Animation)
    pairs = []
    for name in curves:
        a, b = ours.channel(name).astype(np.float64), theirs.channel(name).astype(np.float64)
        pairs.append((a - a[where].mean(), b - b[where].mean()))
    return {"channel_error": np.mean([(a - b) ** 2 for a, b in pairs], axis=0)}, pairs


def _vertex_frames(
    predicted: NDArray[np.floating], captured: NDArray[np.floating], corpus: MotionCorpus, *rest: Any
) -> tuple[dict[str, Array], list[tuple[Array, Array]]]:
    """Distances in mm where the unit is known; curves are displacements from the subject's face at rest."""
    clip, _, _, masks = rest
    face = corpus.rest(clip)
    if face is None:
        raise EvaluationError(
            f"{corpus.clips[clip].name}: has no face at rest; build the corpus with --template"
        )
    apart = distances(predicted, captured) * MILLIMETRES.get(corpus.source.unit, 1.0)
    errors = {"mesh_error": apart.mean(axis=1)}
    if "lips" in masks:
        if masks["lips"].max() >= apart.shape[1]:
            raise EvaluationError(f"mask lips has vertex {masks['lips'].max()}, of {apart.shape[1]}; from 0")
        errors["mesh_lip_error"] = apart[:, masks["lips"]].max(axis=1)
    return errors, [(predicted - face, captured - face)]
