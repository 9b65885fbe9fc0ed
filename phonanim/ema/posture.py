"""Remove head motion: sensors relative to the skull, in the bite plane."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim.ema.articulation import Articulation
from phonanim.errors import CorpusError

Array = NDArray[np.float64]
LEAST = 3  # number of reference sensors that determine the head position
FLAT = 0.05  # least spread of three sensors along the second axis, relative to the first


@dataclass(frozen=True)
class Posture:
    """A head at rest: `rest` (references, 3) mm are its reference sensors; then the bite plane is applied.

    `rotation` (3, 3) has forward, left and up as rows; `origin` (3,) mm is moved to zero.
    """

    references: tuple[str, ...]
    rest: Array
    rotation: Array
    origin: Array


def rest_posture(articulation: Articulation, references: tuple[str, ...]) -> Posture:
    """The median position of reference sensors, with unchanged axes. Raises CorpusError.

    Three sensors that are not on a line determine the head: the bridge of the nose, both mastoids, the upper
    incisors (Medina 2023, section 2.1).
    """
    if len(references) < LEAST:
        raise CorpusError(
            f"{len(references)} reference sensors do not fix the head; name {LEAST} or more on the skull"
        )
    rest = np.stack([_middle(articulation, name) for name in references])
    spread = np.linalg.svd(rest - rest.mean(axis=0), compute_uv=False)
    if spread[1] < FLAT * spread[0]:
        raise CorpusError(f"{articulation.source}: {', '.join(references)} are on a line; name others")
    return Posture(references, rest, np.eye(3), np.zeros(3))


def bite_posture(
    bite: Articulation, references: tuple[str, ...], plate: tuple[str, str, str], origin: str = ""
) -> Posture:
    """The posture of a recording with a plate between the teeth. Raises CorpusError.

    `plate` are its sensors at the front, the left and the right: x goes from the middle of the last two to
    the first, z is perpendicular to the plane of the three, and y is in the plane, to the left. Zero is at
    the front sensor, or at the sensor `origin` (the upper incisors).
    """
    posture = rest_posture(bite, references)
    still = correct_head_motion(bite, posture)
    front, left, right = (_middle(still, name) for name in plate)
    forward, leftward = front - (left + right) / 2, left - right
    up = np.cross(forward, leftward)
    if np.linalg.norm(up) < FLAT * np.linalg.norm(forward) * np.linalg.norm(leftward):
        raise CorpusError(
            f"{bite.source}: {', '.join(plate)} are on a line; name front, left and right of the plate"
        )
    rows = [forward, np.cross(up, forward), up]
    rotation = np.stack([row / np.linalg.norm(row) for row in rows])
    return replace(posture, rotation=rotation, origin=_middle(still, origin) if origin else front)


def correct_head_motion(articulation: Articulation, posture: Posture) -> Articulation:
    """Move and turn every sample rigidly so that its head is at rest, then turn it to the bite plane.

    p' = B (R p + t - o), where R and t fit the references of a sample to their rest by least squares (Kabsch
    1976; Umeyama 1991). Samples without all references are NaN. Raises CorpusError.
    """
    seen = np.stack([articulation.sensor(name) for name in posture.references], axis=1)
    whole = np.isfinite(seen).all(axis=(1, 2))
    moved = np.full_like(articulation.positions, np.nan)
    rotation, shift = rigid_fit(seen[whole], posture.rest)
    still = articulation.positions[whole] @ np.swapaxes(rotation, 1, 2) + shift[:, None]
    moved[whole] = (still - posture.origin) @ posture.rotation.T
    return replace(articulation, positions=moved)


def rigid_fit(points: Array, onto: Array) -> tuple[Array, Array]:
    """R (samples, 3, 3) and t (samples, 3) that fit points (samples, n, 3) to others (n, 3), least squares.

    R is a rotation, never a reflection. Source: Umeyama 1991, equations 39 to 42 without the scale.
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
