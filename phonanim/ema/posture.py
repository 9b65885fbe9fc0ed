"""The head held still: sensors relative to the skull, in the plane of the bite."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim.ema.articulation import Articulation
from phonanim.errors import CorpusError

Array = NDArray[np.float64]
LEAST = 3  # reference sensors that fix a head
FLAT = 0.05  # of their spread along the first axis that three must have along the second


@dataclass(frozen=True)
class Posture:
    """A head at rest: `rest` (references, 3) mm are its reference sensors; the plane of the bite comes after.

    `rotation` (3, 3) has forward, left and up as rows, `origin` (3,) mm is what becomes zero.
    """

    references: tuple[str, ...]
    rest: Array
    rotation: Array
    origin: Array


def rest_posture(articulation: Articulation, references: tuple[str, ...]) -> Posture:
    """The middle (median) position of reference sensors, with the axes as they are. Raises CorpusError.

    Three sensors that do not lie on a line fix a head: the bridge of the nose, both mastoids, the upper
    incisors (Medina 2023, section 2.1).
    """
    if len(references) < LEAST:
        raise CorpusError(
            f"{len(references)} reference sensors fix no head; name {LEAST} or more on the skull"
        )
    rest = np.stack([_middle(articulation, name) for name in references])
    spread = np.linalg.svd(rest - rest.mean(axis=0), compute_uv=False)
    if spread[1] < FLAT * spread[0]:
        raise CorpusError(f"{articulation.source}: {', '.join(references)} lie on a line; name others")
    return Posture(references, rest, np.eye(3), np.zeros(3))


def bite_posture(
    bite: Articulation, references: tuple[str, ...], plate: tuple[str, str, str], origin: str = ""
) -> Posture:
    """The posture of a recording in which a plate is held between the teeth. Raises CorpusError.

    `plate` are its sensors at the front, the left and the right: x runs from the middle of the last two to
    the first, z stands on the plane of the three, y lies in it, to the left. Zero is at the front one, or at
    the sensor `origin` (the upper incisors).
    """
    posture = rest_posture(bite, references)
    still = correct_head_motion(bite, posture)
    front, left, right = (_middle(still, name) for name in plate)
    forward, leftward = front - (left + right) / 2, left - right
    up = np.cross(forward, leftward)
    if np.linalg.norm(up) < FLAT * np.linalg.norm(forward) * np.linalg.norm(leftward):
        raise CorpusError(
            f"{bite.source}: {', '.join(plate)} lie on a line; name front, left and right of the plate"
        )
    rows = [forward, np.cross(up, forward), up]
    rotation = np.stack([row / np.linalg.norm(row) for row in rows])
    return replace(posture, rotation=rotation, origin=_middle(still, origin) if origin else front)


def correct_head_motion(articulation: Articulation, posture: Posture) -> Articulation:
    """Every sample moved and turned as a whole so that its head is at rest, then turned to the bite.

    p' = B (R p + t - o), where R and t bring the references of a sample closest to their rest, in the sum of
    squares (Kabsch 1976; Umeyama 1991). Samples that lack a reference are NaN. Raises CorpusError.
    """
    seen = np.stack([articulation.sensor(name) for name in posture.references], axis=1)
    whole = np.isfinite(seen).all(axis=(1, 2))
    moved = np.full_like(articulation.positions, np.nan)
    rotation, shift = rigid_fit(seen[whole], posture.rest)
    still = articulation.positions[whole] @ np.swapaxes(rotation, 1, 2) + shift[:, None]
    moved[whole] = (still - posture.origin) @ posture.rotation.T
    return replace(articulation, positions=moved)


def rigid_fit(points: Array, onto: Array) -> tuple[Array, Array]:
    """R (samples, 3, 3) and t (samples, 3) that bring points (samples, n, 3) closest to others, (n, 3).

    R is a rotation, never a mirror. Source: Umeyama 1991, equations 39 to 42 without the scale.
    """
    middle, target = points.mean(axis=1), onto.mean(axis=0)
    u, _, v = np.linalg.svd(np.swapaxes(points - middle[:, None], 1, 2) @ (onto - target))
    mirror = np.sign(np.linalg.det(u @ v))
    v[:, 2] *= mirror[:, None]
    rotation = np.swapaxes(u @ v, 1, 2)
    return rotation, target - np.einsum("sij,sj->si", rotation, middle)


def _middle(articulation: Articulation, name: str) -> Array:
    """Median position of a sensor, (3,) mm."""
    track = articulation.sensor(name)
    tracked = track[np.isfinite(track).all(axis=1)]
    if len(tracked) == 0:
        raise CorpusError(f"{articulation.source}: sensor {name} was never tracked; leave it out")
    return np.asarray(np.median(tracked, axis=0))
