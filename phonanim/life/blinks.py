"""Blinks: how often, when and how fast people blink while they talk.

Rates: 26 a minute in conversation, 17 at rest (Bentivoglio et al. 1997, Movement Disorders 12(6), 150
people). Gaps are log-normal. Speakers blink where phrases end (Nakano and Kitazawa 2010, Experimental Brain
Research 205), and with large shifts of gaze (Evinger et al. 1994, Experimental Brain Research 100). The lid
falls in about 80 ms and rises in twice that (VanderWerf et al. 2003, Journal of Neurophysiology 89).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.life.chance import Index, events, lognormal, number_of, uniform
from phonanim.life.shapes import bumps
from phonanim.speech.prosody import Prosody

Array = NDArray[np.float64]

TALKING, RESTING = 26 / 60, 17 / 60  # blinks a second
SPREAD = 0.6  # standard deviation of the logarithm of the gaps
LEAST = 0.6  # seconds from the start of a blink to that of the next; less looks like a flutter
CLOSING, SHUT, OPENING = 0.08, 0.03, 0.16  # seconds
LATE = 1.2  # seconds by which a blink may move earlier to the end of a phrase
REST = 1.0  # seconds after the end of a phrase that count as talking
SHIFT = 20.0  # degrees of a gaze shift above which the eyes may close
WITH_SHIFT = 0.6  # share of such shifts
SQUINT, BROW = 0.15, 0.05  # how much the lower lid and the brow follow
LASTS = CLOSING + SHUT + OPENING


def closed(seed: int, prosody: Prosody, times: Array, shifts: tuple[Array, Array]) -> Array:
    """How far the eyes are closed, (frames,) 0 to 1; `shifts` are instants and degrees of gaze shifts."""
    starts = blink_starts(seed, prosody, float(times[0]), float(times[-1]), shifts)
    each = np.ones(len(starts))
    return bumps(times, starts, CLOSING * each, SHUT * each, OPENING * each, each)


def blink_starts(seed: int, prosody: Prosody, start: float, end: float, shifts: tuple[Array, Array]) -> Array:
    """Start times of the blinks that are visible between two instants, (blinks,) seconds."""

    def gap(numbers: Index) -> Array:
        return LEAST + lognormal(seed, "blink", numbers, 1 / TALKING - LEAST, SPREAD)

    due, numbers = events(seed, "blink", gap, LEAST, start - LASTS - LATE, end + LATE)
    chosen = uniform(seed, "blink kept", numbers)
    ends, known = prosody.ends, prosody.ends_from
    found = []
    for time, chance in zip(due, chosen, strict=True):
        near = np.flatnonzero((ends >= time - LATE) & (known <= time))
        if len(near):
            found.append(max(ends[near[0]], known[near[0]]) + _lag(seed, ends[near[0]]))
        elif chance < RESTING / TALKING or _talks(prosody, time):
            found.append(time)
    large = shifts[0][shifts[1] > SHIFT]
    found += list(large[uniform(seed, "blink shift", number_of(large)) < WITH_SHIFT])
    return _apart(np.unique(found))


def _lag(seed: int, end: float) -> float:
    return 0.12 * float(uniform(seed, "blink lag", number_of(np.array([end])))[0])


def _talks(prosody: Prosody, time: float) -> bool:
    """Whether an instant is in a phrase or just after its end."""
    begun = int(np.searchsorted(prosody.starts_from, time))
    return begun > 0 and bool(prosody.ends_from[begun - 1] > time - REST)


def _apart(starts: Array) -> Array:
    """The blinks without those that follow another at once, as when the eyes turn far away and back."""
    return starts[np.diff(starts, prepend=-np.inf) >= LEAST]
