"""Fill short gaps, resample sensors, and remove motion that is too fast for speech."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim.ema.articulation import Articulation

Array = NDArray[np.float64]
LONGEST = (
    0.05  # seconds; the tongue closes and opens a t in twice this time, so a longer gap may hide a gesture
)
LOBES, BETA = 16, 8.0  # of the sinc on either side, and of its Kaiser window: -80 dB beyond the transition
BELOW = 0.86  # of half the lower rate: start of the transition, so that it ends at half the lower rate
BLOCK = 4096  # samples at a time


@dataclass(frozen=True)
class Gap:
    """A stretch in which a sensor was not tracked, from `start` to `end` in seconds."""

    sensor: str
    start: float
    end: float
    filled: bool


def fill_gaps(articulation: Articulation, longest: float = LONGEST) -> tuple[Articulation, list[Gap]]:
    """Fill gaps of at most `longest` seconds by lines between their ends; -> all gaps, longer ones left NaN.

    Gaps at the beginning or the end are never filled.
    """
    positions, gaps = articulation.positions.copy(), []
    for place, name in enumerate(articulation.names):
        lost = np.asarray(~np.isfinite(positions[:, place]).all(axis=1))
        for begin, end in find_runs(lost):
            inside = begin > 0 and end < len(lost)
            filled = inside and (end - begin) / articulation.rate <= longest + 1e-9
            positions[begin:end, place] = np.nan
            if filled:
                share = np.linspace(0, 1, end - begin + 2)[1:-1, None]
                before, after = positions[begin - 1, place], positions[end, place]
                positions[begin:end, place] = before + share * (after - before)
            times = articulation.start + np.array([begin, end]) / articulation.rate
            gaps.append(Gap(name, float(times[0]), float(times[1]), filled))
    return replace(articulation, positions=positions), gaps


def find_runs(chosen: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Begin and end of every run of true values, [(begin, end), ...]."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(np.int8)))
    return [(int(begin), int(end)) for begin, end in edges.reshape(-1, 2)]


def resample_sensors(articulation: Articulation, rate: float, cutoff: float | None = None) -> Articulation:
    """The same motion at another rate, in hertz, without motion faster than `cutoff`, in hertz.

    At `cutoff` (0.86 of half the lower rate) half the amplitude remains, and nothing (-80 dB) above 1.16
    times `cutoff`. The filter is a windowed sinc, symmetric about each instant, so there is no delay. Its
    weights sum to one, so that a constant is unchanged (Oppenheim and Schafer 2010, sections 4.6 and 7.5).
    Each tracked stretch is extended at its ends by point reflection. Lost samples stay NaN.
    """
    limit = BELOW * min(articulation.rate, rate) / 2
    if rate == articulation.rate and (cutoff is None or cutoff >= limit):
        return articulation
    cutoff = limit if cutoff is None else min(cutoff, limit)
    duration = (len(articulation.positions) - 1) / articulation.rate
    at = np.arange(float(np.floor(duration * rate + 1e-6)) + 1) * (articulation.rate / rate)  # in samples
    found = np.full((len(at), len(articulation.names), 3), np.nan)
    for place in range(len(articulation.names)):
        values = articulation.positions[:, place]
        for begin, end in find_runs(np.asarray(np.isfinite(values).all(axis=1))):
            rows = np.flatnonzero((at >= begin) & (at <= end - 1))
            found[rows, place] = _sinc(values[begin:end], at[rows] - begin, cutoff / articulation.rate)
    return replace(articulation, positions=found, rate=rate)


def _sinc(values: Array, at: Array, cutoff: float) -> Array:
    """Values between samples, (samples, 3), (places,) -> (places, 3); `cutoff` in cycles per sample."""
    reach = int(np.ceil(LOBES / (2 * cutoff)))
    padded = _reflected(values, reach + 1)
    offsets = np.arange(-reach, reach + 1)
    found = np.empty((len(at), 3))
    for start in range(0, len(at), BLOCK):
        block = at[start : start + BLOCK]
        middle = np.floor(block).astype(int)
        away = offsets - (block - middle)[:, None]
        window = np.i0(BETA * np.sqrt(np.clip(1 - (away / (reach + 1)) ** 2, 0, None)))
        weights = np.sinc(2 * cutoff * away) * window
        weights /= weights.sum(axis=1, keepdims=True)
        samples = padded[middle[:, None] + offsets + reach + 1]
        found[start : start + BLOCK] = np.einsum("pk,pka->pa", weights, samples)
    return found


def _reflected(values: Array, count: int) -> Array:
    """`count` more samples on either side, by reflection in the first and the last point."""
    if len(values) == 1:
        return np.repeat(values, 2 * count + 1, axis=0)
    places, last = np.arange(-count, len(values) + count), len(values) - 1
    folds, rest = np.divmod(places, last)
    first, final = values[0], values[-1]
    forward, backward = values[rest], 2 * final - values[last - rest]
    swung = np.where((folds % 2 == 0)[:, None], forward, backward)
    return np.asarray(swung + (folds // 2 * 2)[:, None] * (final - first))
