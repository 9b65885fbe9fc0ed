"""Phones -> articulation in millimetres: targets, blended over time by their weights.

Each gesture (lexicon/gestures.csv; diphthongs and affricates have two) pulls a channel to its target while it
lasts. A greater weight pulls more strongly. The pull has a soft beginning and end:

    y(t) = sum_i w_i T_i K_i(t) / sum_i w_i K_i(t),    K_i = the box of gesture i, convolved with a Gaussian

(after Cohen and Massaro 1993, with another kernel). An instant depends only on gestures within `reach` of it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.channels import CHANNELS, Articulation
from phonanim.articulation.closures import enforce_contacts
from phonanim.articulation.table import Targets, read_targets
from phonanim.speech.gestures import GESTURES, split_parts
from phonanim.speech.phones import PhoneTrack, pair_rows

Array = NDArray[np.float64]

CUT = 4.0  # standard deviations at which the Gaussian is cut off
STEPS = 512  # of a standard deviation, in the table of the Gaussian's integral
_AT = np.linspace(-CUT, CUT, round(2 * CUT * STEPS) + 1)
_CDF = np.array([0.5 * (1 + math.erf(x / math.sqrt(2)) / math.erf(CUT / math.sqrt(2))) for x in _AT])
_SLOPE = np.append(np.diff(_CDF) * STEPS, 0.0)
BLOCK = 8192  # instants per block, so that their data fit in the cache
PAIRS = 16384  # of instants and gestures near them, likewise
ROUNDED = (
    GESTURES.articulation[:, [GESTURES.columns.index(c) for c in ("rounding", "protrusion")]].max(axis=1) > 0
)


def articulate(
    track: PhoneTrack, times: Array, targets: Targets | None = None, contacts: bool = True
) -> Articulation:
    """Articulation at instants, (frames,) seconds in rising order -> (frames, channels) mm.

    Before and after the track is silence: a closed, relaxed mouth. Lips fully close on p b m and meet the
    teeth on f v, unless `contacts` is off.
    """
    targets = targets or read_targets()
    gestures, bounds = _gestures(track)
    values = np.empty((len(times), len(CHANNELS)))
    first = np.searchsorted(bounds[1:], times - CUT * targets.sigma.max(), side="left")
    last = np.searchsorted(bounds[:-1], times + reach(targets), side="right")
    most = int((last - first).max(initial=1))
    size = max(PAIRS // most, 1)
    for start in range(0, len(times), size):
        block = slice(start, start + size)
        near = first[block] + np.arange(most)[:, None]
        values[block] = _blend(gestures, bounds, times[block], near, targets)
    if contacts:
        enforce_contacts(values, track, times)
    return Articulation(values)


def gesture_kernels(track: PhoneTrack, times: Array, sigma: float, lead: float) -> Array:
    """K summed over the segments of each gesture, (frames, gestures), for fitting targets."""
    gestures, bounds = _gestures(track)
    begins, ends = bounds[:-1] - lead * ROUNDED[gestures], bounds[1:]
    count = len(GESTURES.names)
    total = np.empty((len(times), count))
    for start in range(0, len(times), BLOCK):
        near = times[start : start + BLOCK]
        segments, rows, kernel = kernel_pairs(near, begins, ends, sigma)
        sums = np.bincount(rows * count + gestures[segments], kernel, len(near) * count)
        total[start : start + BLOCK] = sums.reshape(len(near), count)
    return total


def kernel_sums(track: PhoneTrack, times: Array, sigma: float, weights: Array) -> Array:
    """Weights of gestures (n, gestures), smoothed in time by a Gaussian, (n, frames) at rising instants."""
    gestures, bounds = _gestures(track)
    return local_sums(bounds, weights[:, gestures], times, sigma)


def local_sums(bounds: Array, values: Array, times: Array, sigma: float) -> Array:
    """Values of segments smoothed in time by a Gaussian, (n, segments) -> (n, frames) at rising instants."""
    chosen = np.flatnonzero(values.any(axis=0))
    begins, ends = bounds[:-1][chosen], bounds[1:][chosen]
    total = np.empty((len(values), len(times)))
    for start in range(0, len(times), BLOCK):
        near = times[start : start + BLOCK]
        segments, rows, kernel = kernel_pairs(near, begins, ends, sigma)
        for place, value in enumerate(values[:, chosen]):
            total[place, start : start + BLOCK] = np.bincount(rows, value[segments] * kernel, len(near))
    return total


def kernel_pairs(
    times: Array, begins: Array, ends: Array, sigma: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Segments, rows and kernels of every instant that a smoothed segment reaches, (pairs,) each."""
    segments, rows = pair_rows(
        np.searchsorted(times, begins - CUT * sigma), np.searchsorted(times, ends + CUT * sigma)
    )
    return segments, rows, box_kernel(times[rows], begins[segments], ends[segments], sigma)


def reach(targets: Targets) -> float:
    """Seconds on either side of an instant that can influence it."""
    return float((CUT * targets.sigma + targets.lead).max())


def _gestures(track: PhoneTrack) -> tuple[NDArray[np.int64], Array]:
    """Gestures (segments,) and their bounds (segments + 1,) seconds, from -inf to inf."""
    parts = split_parts(track)
    silent = GESTURES.names.index("sil")
    gestures = np.concatenate([[silent], GESTURES.part_gesture[parts.parts], [silent]])
    return gestures, np.concatenate([[-np.inf], parts.bounds, [np.inf]])


def _blend(
    gestures: NDArray[np.int64], bounds: Array, times: Array, near: NDArray[np.int64], targets: Targets
) -> Array:
    """Channels at instants, (frames, channels), of the gestures `near` them, (most, frames), in time order.

    The sums run in that order, so that the result does not depend on which other instants are computed in the
    same call. Gestures after the last one do not exist.
    """
    near = np.minimum(near, len(gestures))
    kinds = np.append(gestures, 0).take(near)
    begins, ends = (np.append(part, np.inf).take(near) for part in (bounds[:-1], bounds[1:]))
    timings = list(zip(targets.sigma.tolist(), targets.lead.tolist(), strict=True))
    known = list(dict.fromkeys(timings))  # channels with the same timing share it
    sigma, lead = np.array(known).T[:, :, None, None]
    kernel = box_kernel(times, begins - lead * ROUNDED.take(kinds), ends, sigma)
    kernel = kernel.take([known.index(timing) for timing in timings], axis=0)
    weight = targets.weight.T.take(kinds, axis=1)
    pull = (targets.weight * targets.target).T.take(kinds, axis=1)
    pull *= kernel
    weight *= kernel
    return np.asarray((pull.sum(axis=1) / weight.sum(axis=1)).T)


def box_kernel(times: Array, begin: Array | float, end: Array | float, sigma: Array | float) -> Array:
    """The box from `begin` to `end` seconds, convolved with a Gaussian, at instants, (frames,)."""
    return _cumulative((times - begin) / sigma) - _cumulative((times - end) / sigma)


def _cumulative(x: Array) -> Array:
    """The Gaussian's integral, cut off at CUT standard deviations so that it is 0 and 1 beyond.

    Interpolated as np.interp does it, without the search.
    """
    x = np.clip(x, -CUT, CUT)
    below = np.floor(x * STEPS)
    rows = (below + CUT * STEPS).astype(np.intp)
    below /= STEPS
    x -= below
    x *= _SLOPE.take(rows)
    x += _CDF.take(rows)
    return x
