"""Rigs of mouth shapes: phones choose the shape, the face's motion gives its weight."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation import Articulation
from phonanim.errors import RigError
from phonanim.face.model import FaceModel
from phonanim.rig.coordinate_descent import Problem, descend
from phonanim.rig.landmark_objective import Energy, observe_displacements
from phonanim.rig.pronounce import pronounce
from phonanim.rig.rig import Rig, Visemes
from phonanim.speech.inventory import INVENTORY, SILENCE
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]

HOLD = 0.05  # seconds: a stepped mouth is chosen by the phones around the frame, not by one instant
URGENT = 3.0  # a stepped mouth must show closures: a closure outweighs shapes up to three times as long
CLOSED = ("p", "b", "m", "f", "v")
REACH = 0.05  # seconds before and after its phone in which a consonant's shape may show
# A consonant's shape also has a weight of its own, as a share of the weight that the lips require:
# most of th, kk and nn is behind the lips.
PULL = 0.3
SPARSE = 500.0  # mm² per unit of a vowel's shape: few vowels at a time


def shape_weights(
    modes: NDArray[np.floating], face: FaceModel, rig: Rig, track: PhoneTrack | None, times: Array | None
) -> NDArray[np.float32]:
    """Shape weights at each frame, (frames, m) and (frames,) seconds -> (frames, controls).

    Raises RigError when there are no phones.
    """
    if rig.visemes is None or track is None or times is None:
        raise RigError(f"rig {rig.name} is moved by phones and needs an alignment, not motion alone")
    if rig.visemes.stepped:
        bounds, shapes = spoken_shapes(track, rig.visemes)
        said = np.eye(len(rig.controls), dtype=bool)[shapes]
        return stepped_weights(bounds, said, times, rig.visemes).astype(np.float32)
    near = nearby(rig.visemes, len(rig.controls), track, times)
    return blended_weights(np.asarray(modes, np.float64), near, rig.visemes, face).astype(np.float32)


def nearby(visemes: Visemes, controls: int, track: PhoneTrack, times: Array) -> Array:
    """How near each shape's phones are, 0 to 1, (frames,) seconds -> (frames, controls)."""
    bounds, shapes = spoken_shapes(track, visemes)
    said = np.eye(controls, dtype=bool)[shapes]
    return np.column_stack([shape_proximity(bounds, mine, times) for mine in said.T])


def speak(
    articulation: Articulation, rig: Rig, track: PhoneTrack | None, times: Array | None
) -> NDArray[np.float32]:
    """Shape weights that produce this articulation, (frames, channels) mm -> (frames, controls).

    A consonant's shape is active only near its phones; silence takes the rest of the sum of 1.
    """
    if rig.visemes is None or rig.mouth is None or track is None or times is None:
        raise RigError(f"rig {rig.name} is moved by phones and needs an alignment, not motion alone")
    near = nearby(rig.visemes, len(rig.controls), track, times)
    near[:, vowel_shapes(rig.visemes, len(rig.controls))] = np.inf
    values = pronounce(articulation, rig, rig.mouth, near)
    silent = int(rig.visemes.of[INVENTORY.code(SILENCE), 0])
    values[:, silent] = np.clip(1.0 - np.delete(values, silent, axis=1).sum(axis=1), 0.0, 1.0)
    return values


def spoken_shapes(track: PhoneTrack, visemes: Visemes) -> tuple[Array, NDArray[np.int64]]:
    """The shapes over time: bounds (shapes + 1,) seconds and control rows (shapes,).

    A diphthong shows its first shape in its first half and its second shape in the other half.
    """
    middles = (track.bounds[:-1] + track.bounds[1:]) / 2
    bounds = np.append(np.column_stack([track.bounds[:-1], middles]).ravel(), track.bounds[-1])
    return bounds, visemes.of[track.codes].ravel()


def stepped_weights(bounds: Array, said: NDArray[np.bool_], times: Array, visemes: Visemes) -> Array:
    """One shape at a time, (shapes + 1,), (shapes, controls), (frames,) -> (frames, controls) of 0 and 1."""
    period = float(np.median(np.diff(times))) if len(times) > 1 else HOLD
    half = max(period, HOLD) / 2
    shown = np.column_stack([_time_of(bounds, mine, times, half) for mine in said.T])
    shown[:, visemes.of[INVENTORY.codes(CLOSED)].ravel()] *= URGENT
    return np.eye(shown.shape[1])[shown.argmax(axis=1)]


def _time_of(bounds: Array, said: NDArray[np.bool_], times: Array, half: float) -> Array:
    """Seconds of a shape within `half` of each time, (frames,)."""
    spent = np.concatenate([[0.0], np.cumsum(np.diff(bounds) * said)])
    return np.asarray(np.interp(times + half, bounds, spent) - np.interp(times - half, bounds, spent))


def blended_weights(modes: Array, near: Array, visemes: Visemes, face: FaceModel) -> Array:
    """Weights that add up to the face's motion, (frames, m), (frames, controls) -> (frames, controls).

    Bounded least squares of the visible mouth (`landmark_objective.observe_displacements`). A vowel's shape
    is active at any time, as far as the lips move in its direction. A consonant's shape is active where its
    phones are `near`. Silence takes the rest of the sum of 1.
    """
    silent = int(visemes.of[INVENTORY.code(SILENCE), 0])
    faces = visemes.shapes * face.std
    seen = observe_displacements(face.modes, face, Energy())
    moves = (faces - faces[silent]) @ seen
    gram, free = moves @ moves.T, vowel_shapes(visemes, len(moves))
    ceiling, own = np.where(free, 1.0, near), np.where(free, 0.0, PULL * np.diag(gram))
    ceiling[:, silent] = 0.0
    problem = Problem(
        gram=gram + np.diag(own),
        pull=(modes - faces[silent]) @ (seen @ moves.T) + own * ceiling,
        minimum=np.zeros(len(moves)),
        maximum=ceiling,
        sparse=np.where(free, SPARSE, 0.0),
        smooth=0.0,
        ends=np.array([len(modes)]),
    )
    weights = descend(problem, np.zeros_like(ceiling))
    weights[:, silent] = np.clip(1.0 - weights.sum(axis=1), 0.0, 1.0)
    return weights


def vowel_shapes(visemes: Visemes, controls: int) -> NDArray[np.bool_]:
    """Which shapes are used for more vowels than consonants, (controls,)."""
    vowel = INVENTORY.where(kind="vowel")
    said = np.zeros((controls, 2), np.int64)
    np.add.at(said, (visemes.of.ravel(), np.repeat(vowel.astype(np.int64), 2)), 1)
    return np.asarray(said[:, 1] > said[:, 0])


def shape_proximity(bounds: Array, said: NDArray[np.bool_], times: Array) -> Array:
    """One during a shape, falling to zero at REACH before and after, (frames,)."""
    starts, ends = bounds[:-1][said], bounds[1:][said]
    after = np.searchsorted(starts, times, side="right")
    since = times - np.append(-np.inf, ends)[after]
    until = np.append(starts, np.inf)[after] - times
    return np.clip(1.0 - np.maximum(np.minimum(since, until), 0.0) / REACH, 0.0, 1.0)
