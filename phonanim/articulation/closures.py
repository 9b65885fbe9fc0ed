"""Contacts that blending must keep: lips close on p b m, meet the teeth on f v, teeth are close in sibilants.

Blending alone leaves a closure of 30 ms between open vowels half open. This module limits a channel from
above during such a gesture. The limit is released along half a cosine, so that lips do not jump.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.channels import CHANNELS, Articulation
from phonanim.options import Closure
from phonanim.speech.gestures import GESTURES, split_parts
from phonanim.speech.phones import PhoneTrack, pair_rows

Array = NDArray[np.float64]

CORE = 0.4  # share of the gesture that has full contact
LEAST = 0.042  # minimum seconds of contact: a frame of film
RAMP = 0.06  # seconds before and after it
THRUST = 0.08  # the same for the tip of the tongue between the teeth
RISE = 16.0  # mm, more than any channel exceeds its limit, so that the bound ends with its ramp
CLOSED = -0.5  # mm: lips press on each other (Löfqvist and Gracco 1996)
APART = 2.5  # mm between lips that are kept apart; set by eye
# Column of lexicon/gestures.csv, channel, limit in mm.
LIMITS = (
    ("lip_closure", "lip_gap", CLOSED),
    ("lip_to_teeth", "lower_lip_to_teeth", 0.3),
    ("sibilant", "jaw", 1.2),
)
# The same from below: the tip of the tongue comes between the teeth, and the jaw gives it room.
LEAST_LIMITS = (("dental", "tongue_tip_front", 9.5), ("dental", "jaw", 3.6))


def enforce_contacts(values: Array, track: PhoneTrack, times: Array) -> None:
    """Limit channels in place, (frames, channels) mm at (frames,) seconds in rising order."""
    parts = split_parts(track)
    gestures = GESTURES.part_gesture[parts.parts]
    for column, channel, limit in LIMITS:
        bound = _bound(_named(column, gestures), parts.bounds, times, limit)
        place = CHANNELS.index(channel)
        values[:, place] = np.minimum(values[:, place], bound)
    for column, channel, limit in LEAST_LIMITS:
        bound = _bound(_named(column, gestures), parts.bounds, times, -limit, limit, THRUST)
        place = CHANNELS.index(channel)
        values[:, place] = np.maximum(values[:, place], -bound)


def set_closures(mouth: Articulation, closures: Sequence[Closure], times: Array) -> Articulation:
    """A mouth whose lips are held closed, or apart, where a person asks for it, at (frames,) seconds.

    Lips held closed touch for the whole span. Lips kept apart are as far apart as a lax approximant leaves
    them; they part and meet within the span.
    """
    if not closures:
        return mouth
    values = mouth.values.copy()
    gap = values[:, mouth.channels.index("lip_gap")]
    for closure in closures:
        if closure.kind == "hold":
            outside = np.maximum(np.maximum(closure.start - times, times - closure.end), 0.0)
            bound = CLOSED + RISE * (1 - np.cos(np.pi * np.clip(outside / RAMP, 0, 1))) / 2
            gap[:] = np.where(outside < RAMP, np.minimum(gap, bound), gap)
        else:
            ramp = min(RAMP, (closure.end - closure.start) / 2)
            inside = np.minimum(times - closure.start, closure.end - times)
            share = (1 - np.cos(np.pi * np.clip(inside / ramp, 0, 1))) / 2
            gap[:] = np.where(
                inside > 0, np.maximum(gap, share * APART + (1 - share) * np.minimum(gap, 0)), gap
            )
    return Articulation(values, mouth.channels)


def _named(column: str, gestures: NDArray[np.int64]) -> NDArray[np.int64]:
    """Which of some gestures have a column of lexicon/gestures.csv, as rows of them."""
    return np.flatnonzero((GESTURES.articulation[:, GESTURES.columns.index(column)] > 0)[gestures])


def _bound(
    segments: NDArray[np.int64],
    bounds: Array,
    times: Array,
    limit: float,
    rise: float = RISE,
    ramp: float = RAMP,
) -> Array:
    """The largest value allowed, (frames,) mm; inf where free."""
    bound = np.full(len(times), np.inf)
    begin, end = bounds[segments], bounds[segments + 1]
    middles, halves = (begin + end) / 2, np.maximum(CORE * (end - begin), LEAST) / 2
    first = np.searchsorted(times, middles - halves - ramp)
    last = np.searchsorted(times, middles + halves + ramp)
    near, rows = pair_rows(first, last)
    away = np.clip((np.abs(times[rows] - middles[near]) - halves[near]) / ramp, 0, 1)
    np.minimum.at(bound, rows, limit + rise * (1 - np.cos(np.pi * away)) / 2)
    return bound
