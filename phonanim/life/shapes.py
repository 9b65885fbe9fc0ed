"""Curves over time that behaviours are built from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.speech.phones import pair_rows
from phonanim.speech.prosody import eased

Array = NDArray[np.float64]


def bumps(times: Array, onsets: Array, rises: Array, holds: Array, falls: Array, heights: Array) -> Array:
    """The largest of bumps that rise, hold and fall, all (bumps,) seconds, at instants, (frames,).

    Heights are not negative, so that the curve does not jump where bumps overlap.
    """
    total = np.zeros(len(times))
    first, last = np.searchsorted(times, [onsets, onsets + rises + holds + falls])
    near, rows = pair_rows(first, last)
    past, lasts = times[rows] - onsets[near], rises + holds + falls
    going = heights[near] * eased(past / rises[near]) * eased((lasts[near] - past) / falls[near])
    np.maximum.at(total, rows, going)
    return total


def fade(times: Array, duration: float, ahead: float, rise: float = 0.4, fall: float = 0.5) -> Array:
    """0 at the start and end of a line, 1 in between, (frames,)."""
    fall = min(fall, ahead)
    going = eased(times / rise)
    if np.isfinite(duration) and fall > 0:
        going = going * eased((duration - times) / fall)
    return np.asarray(going)
