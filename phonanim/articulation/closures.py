"""Contacts that blending must keep: lips close on p b m, meet the teeth on f v, teeth are close in sibilants.

Blending alone leaves a closure of 30 ms between open vowels half open. This module limits a channel from
above during such a gesture. The limit is released along half a cosine, so that lips do not jump.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.channels import CHANNELS
from phonanim.speech.gestures import GESTURES, split_parts
from phonanim.speech.phones import PhoneTrack, pair_rows

Array = NDArray[np.float64]

CORE = 0.4  # share of the gesture that has full contact
LEAST = 0.042  # minimum seconds of contact: a frame of film
RAMP = 0.06  # seconds before and after it
RISE = 16.0  # mm, more than any channel exceeds its limit, so that the bound ends with its ramp
# Column of lexicon/gestures.csv, channel, limit in mm. Lips press on each other (Löfqvist and Gracco 1996).
LIMITS = (
    ("lip_closure", "lip_gap", -0.5),
    ("lip_to_teeth", "lower_lip_to_teeth", 0.3),
    ("sibilant", "jaw", 1.2),
)


def enforce_contacts(values: Array, track: PhoneTrack, times: Array) -> None:
    """Limit channels in place, (frames, channels) mm at (frames,) seconds in rising order."""
    parts = split_parts(track)
    gestures = GESTURES.part_gesture[parts.parts]
    for column, channel, limit in LIMITS:
        named = GESTURES.articulation[:, GESTURES.columns.index(column)] > 0
        bound = _bound(np.flatnonzero(named[gestures]), parts.bounds, times, limit)
        place = CHANNELS.index(channel)
        values[:, place] = np.minimum(values[:, place], bound)


def _bound(segments: NDArray[np.int64], bounds: Array, times: Array, limit: float) -> Array:
    """The largest value allowed, (frames,) mm; inf where free."""
    bound = np.full(len(times), np.inf)
    begin, end = bounds[segments], bounds[segments + 1]
    middles, halves = (begin + end) / 2, np.maximum(CORE * (end - begin), LEAST) / 2
    first = np.searchsorted(times, middles - halves - RAMP)
    last = np.searchsorted(times, middles + halves + RAMP)
    near, rows = pair_rows(first, last)
    away = np.clip((np.abs(times[rows] - middles[near]) - halves[near]) / RAMP, 0, 1)
    np.minimum.at(bound, rows, limit + RISE * (1 - np.cos(np.pi * away)) / 2)
    return bound
