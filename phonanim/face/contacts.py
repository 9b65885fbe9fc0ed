"""Contacts: enforce that lips close on p b m, meet the teeth on f v, and round on sh zh ch jh.

A regressor predicts the mean of its training data, so closures of 30 ms come out half closed, and phones
that are not in the recordings resemble their neighbours. Here a measure of the lips gets an upper bound
while such a phone lasts, and any excess is removed by the smallest change of the modes (in units of the
face's own variation).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from phonanim.core.exact import ordered_product
from phonanim.face.model import (
    INNER_LIP_PAIRS,
    LOWER_LIP_INNER,
    LOWER_LIP_OUTER,
    MOUTH_CORNER_LEFT,
    MOUTH_CORNER_RIGHT,
    UPPER_LIP_INNER,
    UPPER_LIP_OUTER,
    FaceModel,
)
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack, pair_rows

Array = NDArray[np.float64]
Measure = Literal["gap", "width"]


@dataclass(frozen=True)
class Contact:
    """A bound on a measure of the lips (mm): `limit` at the core of the phones, released over `ramp` seconds.

    The core is the middle `core` share of the phone. Lips cannot jump: before and after the core the bound
    rises by up to `rise` mm, so that the closure of a quick p between open vowels starts in the vowel.
    """

    phones: tuple[str, ...]
    measure: Measure
    limit: float
    core: float
    ramp: float
    rise: float


# Limits are medians of captured motion in the middle of phones. Gap: p b m 0.35, 0.32, 0.27 mm (a tracker's
# closed lips are not quite at zero). f has 1.9 mm; v has the same, because its lax half-open lips are
# realistic but look like a mistake. Width: w, 49.5 mm, is used for postalveolars, which English rounds; the
# recordings have them only next to spread vowels ("h", "g", "j").
# A rise is more than the measure ever exceeds its limit, so that the bound has no effect beyond its ramp.
CONTACTS = (
    Contact(("p", "b", "m"), "gap", limit=0.3, core=0.4, ramp=0.06, rise=14.0),
    Contact(("f", "v"), "gap", limit=1.9, core=0.3, ramp=0.06, rise=14.0),
    Contact(("sh", "zh", "ch", "jh"), "width", limit=49.5, core=0.3, ramp=0.09, rise=10.0),
)
PHONES = [INVENTORY.mask(*contact.phones) for contact in CONTACTS]
MEASURED = (
    UPPER_LIP_OUTER,
    UPPER_LIP_INNER,
    LOWER_LIP_INNER,
    LOWER_LIP_OUTER,
    MOUTH_CORNER_RIGHT,
    MOUTH_CORNER_LEFT,
)  # by `lip_aperture`, `lip_width` and `lip_protrusion`
AT_REST = 0.2  # mm: tracked lips that touch lie this far apart
SWEEPS = 8  # of the alternating projections; the bounds then hold to a hundredth of a millimetre


def enforce_lip_contacts(
    modes: NDArray[np.float32], track: PhoneTrack, face: FaceModel, times: Array
) -> NDArray[np.float32]:
    """Bound the lips of predicted motion, (frames, modes) at rising instants (frames,) -> the same shape.

    Frames without such a phone nearby are unchanged, and so are frames within the bounds.
    """
    gap, width = contact_limits(track, times, "gap"), contact_limits(track, times, "width")
    near = np.flatnonzero(np.isfinite(gap) | np.isfinite(width))
    if len(near) == 0:
        return modes
    weights, offset = lip_functionals(face)
    limits = np.column_stack([np.tile(gap[near, None], len(INNER_LIP_PAIRS)), width[near]])
    closed: NDArray[np.float32] = modes.copy()
    closed[near] = project_within_limits(modes[near].astype(np.float64), weights, limits - offset, face.std)
    return closed


def contact_limits(track: PhoneTrack, times: Array, measure: Measure) -> Array:
    """The largest allowed value at rising instants, (times,) seconds -> (times,) mm; inf without a bound."""
    limits = np.full(len(times), np.inf)
    for contact, phones in zip(CONTACTS, PHONES, strict=True):
        segments = np.flatnonzero(phones[track.codes])
        if contact.measure != measure or len(segments) == 0:
            continue
        begin, end = track.bounds[segments], track.bounds[segments + 1]
        middle, half = (begin + end) / 2, (end - begin) / 2 * contact.core
        reach = half + contact.ramp
        near, rows = pair_rows(np.searchsorted(times, middle - reach), np.searchsorted(times, middle + reach))
        away = np.clip((np.abs(times[rows] - middle[near]) - half[near]) / contact.ramp, 0, 1)
        np.minimum.at(limits, rows, contact.limit + contact.rise * (1 - np.cos(np.pi * away)) / 2)
    return limits


def project_within_limits(modes: Array, weights: Array, limits: Array, std: Array) -> Array:
    """Move modes (frames, m) as little as possible until modes @ weights.T <= limits (frames, functionals).

    The change is measured in standard deviations `std` (m,), so this face closes its mouth in its usual way
    (Hildreth's alternating projections with memory; Boyle and Dykstra 1986).
    """
    directions = weights * std**2
    norms = (directions * weights).sum(axis=1)
    effect = ordered_product(directions, (weights / norms[:, None]).T)[:, :, None]
    excess = (ordered_product(modes, weights.T) - limits) / norms
    beyond = np.flatnonzero((excess > 0).any(axis=1))
    excess, multipliers = excess[beyond].T.copy(), np.zeros((len(weights), len(beyond)))
    bound = np.flatnonzero((excess > -np.inf).any(axis=1)).tolist()
    for _ in range(SWEEPS):
        for k in bound:
            step = multipliers[k] + excess[k]
            np.maximum(step, 0, out=step)
            step -= multipliers[k]
            multipliers[k] += step
            excess -= step * effect[k]
    moved: Array = modes.copy()
    moved[beyond] -= ordered_product(multipliers.T, directions)
    return moved


@lru_cache(maxsize=8)
def closed_shape(face: FaceModel) -> Array:
    """The face with its lips shut that is nearest to the mean face, (landmarks, 3) mm: a mouth at rest."""
    weights, offset = lip_functionals(face)
    limits = np.full((1, len(offset)), np.inf)
    limits[0, : len(INNER_LIP_PAIRS)] = AT_REST
    modes = project_within_limits(np.zeros((1, len(face.std))), weights, limits - offset, face.std)
    return np.asarray(face.instance(modes)[0])


@lru_cache(maxsize=8)
def lip_part(face: FaceModel) -> tuple[FaceModel, Array]:
    """The landmarks that lips are measured by, as a face, and those of `closed_shape`, (6, 3) mm.

    Their shapes take a thirtieth of the time and memory of whole faces.
    """
    rows = face.rows(MEASURED)
    return FaceModel(face.mean[rows], face.modes[:, rows], face.std, face.indices[rows]), closed_shape(face)[
        rows
    ]


@lru_cache(maxsize=8)
def lip_functionals(face: FaceModel) -> tuple[Array, Array]:
    """The gaps of the inner-lip pairs, then the mouth's width: weights (8, m) on the modes, offset (8,)."""
    upper, lower = (face.rows(side) for side in zip(*INNER_LIP_PAIRS, strict=True))
    right, left = face.rows((MOUTH_CORNER_RIGHT, MOUTH_CORNER_LEFT))
    gaps = (face.modes[:, upper, 1] - face.modes[:, lower, 1]).T
    width = face.modes[:, left, 0] - face.modes[:, right, 0]
    offsets = [*(face.mean[upper, 1] - face.mean[lower, 1]), face.mean[left, 0] - face.mean[right, 0]]
    return np.vstack([gaps, width]), np.array(offsets)
