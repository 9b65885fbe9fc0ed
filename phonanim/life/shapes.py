"""Curves over time that behaviours are built from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.speech.prosody import eased

Array = NDArray[np.float64]


def bumps(times: Array, onsets: Array, rises: Array, holds: Array, falls: Array, heights: Array) -> Array:
    """The largest of bumps that rise, hold and fall, all (bumps,) seconds, at instants, (frames,).

    Heights are not negative, so that the curve does not jump where bumps overlap.
    """
    total = np.zeros(len(times))
    seen = (onsets <= times[-1:]) & (onsets + rises + holds + falls >= times[:1])
    shapes = [part[seen] for part in (onsets, rises, holds, falls, heights)]
    for onset, rise, hold, fall, height in zip(*shapes, strict=True):
        rows = slice(*np.searchsorted(times, [onset, onset + rise + hold + fall]))
        past = times[rows] - onset
        going = height * eased(past / rise) * eased((rise + hold + fall - past) / fall)
        total[rows] = np.maximum(going, total[rows])
    return total


def fade(times: Array, duration: float, ahead: float, rise: float = 0.4, fall: float = 0.5) -> Array:
    """0 at the start and end of a line, 1 in between, (frames,)."""
    fall = min(fall, ahead)
    going = eased(times / rise)
    if np.isfinite(duration) and fall > 0:
        going = going * eased((duration - times) / fall)
    return np.asarray(going)
