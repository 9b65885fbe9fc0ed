"""Whether the extrema of two curves come at the same instants: MTM."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.metrics.arrays import Array

PROMINENCE = 0.5  # standard deviations that an extremum must stand out; smaller ones are jitter
REACH = 0.25  # seconds that the warping may move a frame


def temporal_misalignment(
    predicted: NDArray[np.floating], captured: NDArray[np.floating], fps: float
) -> float:
    """MTM: mean distance in time of corresponding extrema of two curves, (frames,) each -> seconds.

    The curves are scaled to deviation 1 and warped onto each other (dynamic time warping over value and
    slope, within REACH). For each extremum of the captured curve, the nearest extremum of its kind to the
    frame that it is warped to: mean |t_v - t_w|, a frame lasting 1 / fps (after Chae-Yeon et al. 2025). A
    constant delay counts in full. NaN when a curve is constant, or when no extremum has a counterpart.
    """
    if min(np.ptp(predicted), np.ptp(captured)) == 0:
        return float("nan")
    ours, theirs = (np.asarray(c, np.float64) for c in (predicted, captured))
    ours, theirs = ((c - c.mean()) / c.std() for c in (ours, theirs))
    places = _warp(ours, theirs, max(1, round(REACH * fps)))
    apart = []
    for sign in (1, -1):
        mine = np.asarray(find_peaks(sign * ours))
        for peak in find_peaks(sign * theirs) if len(mine) else ():
            nearest = mine[np.abs(mine - places[peak]).argmin()]
            apart.append(abs(nearest - peak) / fps)
    return float(np.mean(apart)) if apart else float("nan")


def find_peaks(curve: Array, prominence: float = PROMINENCE) -> list[int]:
    """Frames of maxima that rise by `prominence` above the lowest points around them, (frames,)."""
    inner = np.flatnonzero((curve[1:-1] > curve[:-2]) & (curve[1:-1] >= curve[2:])) + 1
    found = []
    for frame in inner:
        higher = np.flatnonzero(curve > curve[frame])
        left = higher[higher < frame].max(initial=-1) + 1
        right = higher[higher > frame].min(initial=len(curve))
        base = max(curve[left : frame + 1].min(), curve[frame:right].min())
        if curve[frame] - base >= prominence:
            found.append(int(frame))
    return found


def _warp(ours: Array, theirs: Array, reach: int) -> Array:
    """The frame of `ours` for each frame of `theirs`: a mean over the cheapest path within `reach`."""
    price = _prices(ours, theirs, reach)
    row, column = len(theirs) - 1, len(ours) - 1
    totals, counts = np.zeros(len(theirs)), np.zeros(len(theirs))
    while True:
        totals[row] += column
        counts[row] += 1
        if row == column == 0:
            return np.asarray(totals / counts)
        before = ((row - 1, column - 1), (row - 1, column), (row, column - 1))
        row, column = min((p for p in before if min(p) >= 0), key=lambda place: price[place])


def _prices(ours: Array, theirs: Array, reach: int) -> Array:
    """The price of the cheapest path to each pair of frames, (theirs, ours); infinite outside the band."""
    mine, wanted = (np.column_stack([c, np.gradient(c) / np.gradient(c).std()]) for c in (ours, theirs))
    band = max(reach, abs(len(ours) - len(theirs)) + 1)
    price = np.full((len(theirs), len(ours)), np.inf)
    for row in range(len(theirs)):
        first, last = max(0, row - band), min(len(ours), row + band + 1)
        costs = np.abs(mine[first:last] - wanted[row]).sum(axis=1).tolist()
        above = price[row - 1, first:last].tolist() if row else [np.inf] * len(costs)
        corner = float(price[row - 1, first - 1]) if row and first else np.inf
        left = np.inf
        for place, cost in enumerate(costs):
            best = min(corner, above[place], left) if row or place else 0.0
            corner, left = above[place], best + cost
            price[row, first + place] = left
    return price
