"""Measures of a clip as sums that pool over clips: the rows of phonanim.evaluation.statistics."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim import metrics
from phonanim.comparison.folds import Where
from phonanim.comparison.measures import MEASURES
from phonanim.corpus.corpus import Corpus
from phonanim.evaluation.statistics import pearson_sums
from phonanim.face.model import INNER_LIPS, OUTER_LIPS, FaceModel, lip_aperture, lip_width
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Scores = dict[str, Array]  # measure -> (clips, sums)


def clip_scores(
    shapes: NDArray[np.floating],
    captured: NDArray[np.floating],
    face: FaceModel,
    track: PhoneTrack,
    fps: float,
    where: NDArray[np.bool_],
) -> dict[str, Array]:
    """Sums of every measure over the chosen frames of one clip.

    `shapes` and `captured` are (frames, landmarks, 3) mm at (n + 0.5) / fps seconds, `where` (frames,).
    Parameter MSE is the squared distance in the space of the face's modes divided by their number, shape
    MSE the mean squared coordinate error of the moving landmarks (Taylor 2017, section 8.1), LVE the mean
    over frames of the largest distance of a lip point (Richard 2021), velocity error the mean distance of
    the moving landmarks' velocities.
    """
    apart = (shapes - captured)[:, face.moving]
    parameters = face.project(shapes) - face.project(captured)
    lips = face.rows((*OUTER_LIPS, *INNER_LIPS))
    velocity = np.linalg.norm(np.diff(apart, axis=0) * fps, axis=2).mean(axis=1)
    largest = np.linalg.norm((shapes - captured)[:, lips], axis=2).max(axis=1)
    aperture, width = lip_aperture, lip_width
    return {
        "parameter_mse": _sum((parameters**2).mean(axis=1)[where]),
        "shape_mse": _sum((apart**2).mean(axis=(1, 2))[where]),
        "vertex_error": _sum(np.linalg.norm(apart, axis=2).mean(axis=1)[where]),
        "lip_error": _sum(largest[where]),
        "speed_error": _sum(velocity[where[1:] & where[:-1]]),
        "aperture_r": pearson_sums(aperture(shapes, face)[where], aperture(captured, face)[where]),
        "width_r": pearson_sums(width(shapes, face)[where], width(captured, face)[where]),
        "pbm_gap": _sum(_gaps(shapes, face, track, fps, where)),
    }


def scores_by_frames(
    name: str,
    shapes: Iterable[tuple[int, NDArray[np.floating]]],
    where: Mapping[str, Where],
    corpus: Corpus,
    face: FaceModel,
) -> dict[str, dict[str, list[Any]]]:
    """Sums by "name/frames", measure and clip, of clips with their shapes (frames, landmarks, 3)."""
    rows: dict[str, list[dict[str, Array]]] = {frames: [] for frames in where}
    for clip, predicted in shapes:
        captured, track = corpus.landmarks[corpus.rows([clip])], corpus.tracks[clip]
        for frames, chosen in where.items():
            found = clip_scores(predicted, captured, face, track, corpus.fps, chosen(corpus, clip))
            rows[frames].append(found)
    return {
        f"{name}/{frames}": {measure: [short(row[measure]) for row in clips] for measure in clips[0]}
        for frames, clips in rows.items()
    }


def short(sums: Array) -> list[float]:
    """Nine significant digits: enough for any statistic, and half the file size."""
    return [float(f"{number:.9g}") for number in sums]


def measure_value(name: str, rows: Array) -> float:
    """One number for some clips, (clips, sums)."""
    return float(MEASURES[name].statistic(np.asarray(rows).sum(axis=0)))


def _sum(values: Array) -> Array:
    return np.array([values.sum(), len(values)], np.float64)


def _gaps(
    shapes: NDArray[np.floating],
    face: FaceModel,
    track: PhoneTrack,
    fps: float,
    where: NDArray[np.bool_],
) -> Array:
    """Lip gap at the frame nearest to the middle of every p, b and m in the chosen frames."""
    frames = np.round(metrics.phone_middles(track, ("p", "b", "m")) * fps - 0.5)
    frames = np.clip(frames, 0, len(shapes) - 1).astype(int)
    return metrics.lip_gap(shapes[frames[where[frames]]], face)
