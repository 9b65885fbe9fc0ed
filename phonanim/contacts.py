"""Contacts: lips that really close on p b m, and a lower lip that meets the teeth on f v.

A regressor answers with the mean of what it has seen, so closures of 30 ms come out half closed. Here
the gap between the lips is bounded from above while such a phone lasts, and what is too much is taken
away by the smallest change of the modes (in the captured face's own variation) that does it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.face import INNER_LIP_PAIRS, FaceModel
from phonanim.inventory import INVENTORY
from phonanim.phones import PhoneTrack

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Contact:
    """A bound on the inner-lip gap (mm): `gap` at the core of the phones, released over `ramp` seconds.

    The core is the middle `core` share of the phone. A lip cannot jump: before and after the core the
    bound rises smoothly, so a quick p between open vowels starts to close while the vowel lasts.
    """

    phones: tuple[str, ...]
    gap: float
    core: float
    ramp: float


# The gap is the median captured at the middle of these phones in the recordings (0.35, 0.32, 0.27 mm for
# p b m; a tracker's closed lips are not quite at zero), and for f and v the lowest quarter of f: v is often
# spoken with less, but a lower lip that stays away from the teeth is what an animator would correct.
CONTACTS = (
    Contact(("p", "b", "m"), gap=0.3, core=0.4, ramp=0.06),
    Contact(("f", "v"), gap=1.2, core=0.3, ramp=0.06),
)
RISE = 14.0  # mm: more than any gap in speech, so that the bound ends at the end of its ramp


def close(
    modes: NDArray[np.float32], track: PhoneTrack, face: FaceModel, fps: float, start: float = 0.0
) -> NDArray[np.float32]:
    """Bound the lip gaps of predicted motion, (frames, modes) at start + n / fps -> the same shape.

    Frames without such a phone nearby come back unchanged, as do frames whose lips are closed already.
    """
    times = start + np.arange(len(modes)) / fps
    bound = gap_bound(track, times)
    near = np.flatnonzero(np.isfinite(bound))
    if len(near) == 0:
        return modes
    closed = modes.copy()
    closed[near] = bounded(modes[near].astype(np.float64), bound[near], face)
    return closed


def gap_bound(track: PhoneTrack, times: Array) -> Array:
    """The largest inner-lip gap allowed at instants, (times,) seconds -> (times,) mm; inf where free."""
    bound = np.full(len(times), np.inf)
    for contact in CONTACTS:
        codes = INVENTORY.codes(contact.phones)
        for segment in np.flatnonzero(np.isin(track.codes, codes)):
            begin, end = track.bounds[segment : segment + 2]
            middle, half = (begin + end) / 2, (end - begin) / 2 * contact.core
            first, last = np.searchsorted(times, (middle - half - contact.ramp, middle + half + contact.ramp))
            away = np.maximum(np.abs(times[first:last] - middle) - half, 0) / contact.ramp
            rising = contact.gap + RISE * (1 - np.cos(np.pi * np.minimum(away, 1))) / 2
            bound[first:last] = np.minimum(bound[first:last], rising)
    return bound


def bounded(modes: Array, bound: Array, face: FaceModel) -> Array:
    """Modes (frames, m) moved as little as possible until no inner-lip pair is further apart than `bound`.

    The change is measured in standard deviations of the modes, so it takes the way in which this face
    closes its mouth. Pairs are treated in turn, the widest first (Hildreth's projections).
    """
    gaps, offset = gap_functionals(face)
    scaled = gaps * face.std**2  # directions of least change
    norms = (scaled * gaps).sum(axis=1)
    moved, multipliers = modes.copy(), np.zeros((len(modes), len(gaps)))
    for _ in range(8):
        for pair in range(len(gaps)):
            excess = moved @ gaps[pair] + offset[pair] - bound
            step = np.maximum(multipliers[:, pair] + excess / norms[pair], 0) - multipliers[:, pair]
            multipliers[:, pair] += step
            moved -= step[:, None] * scaled[pair]
    return moved


def gap_functionals(face: FaceModel) -> tuple[Array, Array]:
    """The gap of each inner-lip pair as a function of the modes: weights (pairs, m), offset (pairs,) mm."""
    upper, lower = (face.rows(side) for side in zip(*INNER_LIP_PAIRS, strict=True))
    weights = (face.modes[:, upper, 1] - face.modes[:, lower, 1]).T
    return weights, face.mean[upper, 1] - face.mean[lower, 1]
