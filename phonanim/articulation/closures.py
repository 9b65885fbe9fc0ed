"""Contacts that blending must keep: lips close on p b m, meet the teeth on f v, teeth are close in sibilants.

Blending alone leaves a closure of 30 ms between open vowels half open. This module limits a channel from
above during such a gesture. The limit is released along half a cosine, so that lips do not jump.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

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


class Limit(NamedTuple):
    """What a column of lexicon/gestures.csv asks of a channel: `most` mm, `rise` more `ramp` s away."""

    column: str
    channel: str
    most: float
    rise: float = RISE
    ramp: float = RAMP


LIMITS = (
    Limit("lip_closure", "lip_gap", CLOSED),
    Limit("lip_to_teeth", "lower_lip_to_teeth", 0.3),
    Limit("sibilant", "jaw", 1.2),
)
# The same from below, with the sign changed: the tip of the tongue comes between the teeth, and the jaw gives
# it room.
LEAST_LIMITS = (
    Limit("dental", "tongue_tip_front", -9.5, 9.5, THRUST),
    Limit("dental", "jaw", -3.6, 3.6, THRUST),
)
_ALL = (*LIMITS, *LEAST_LIMITS)
_ASKED = GESTURES.articulation[:, [GESTURES.columns.index(limit.column) for limit in _ALL]].T > 0
_MOST, _RISES, _RAMPS = np.array([(limit.most, limit.rise, limit.ramp) for limit in _ALL]).T


def enforce_contacts(values: Array, track: PhoneTrack, times: Array) -> None:
    """Limit channels in place, (frames, channels) mm at (frames,) seconds in rising order."""
    for number, bound in enumerate(_bounds(track, times)):
        column = values[:, CHANNELS.index(_ALL[number].channel)]
        if number < len(LIMITS):
            np.minimum(column, bound, out=column)
        else:
            np.maximum(column, -bound, out=column)


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


def _bounds(track: PhoneTrack, times: Array) -> Array:
    """The largest value that each limit allows, (limits, frames) mm; inf where free."""
    parts = split_parts(track)
    limits, segments = np.nonzero(_ASKED[:, GESTURES.part_gesture[parts.parts]])
    begin, end, ramps = parts.bounds[segments], parts.bounds[segments + 1], _RAMPS[limits]
    middles, halves = (begin + end) / 2, np.maximum(CORE * (end - begin), LEAST) / 2
    first = np.searchsorted(times, middles - halves - ramps)
    last = np.searchsorted(times, middles + halves + ramps)
    near, rows = pair_rows(first, last)
    kinds = limits[near]
    away = np.clip((np.abs(times[rows] - middles[near]) - halves[near]) / ramps[near], 0, 1)
    allowed = _MOST[kinds] + _RISES[kinds] * (1 - np.cos(np.pi * away)) / 2
    bounds = np.full((len(_ALL), len(times)), np.inf)
    np.minimum.at(bounds, (kinds, rows), allowed)
    return bounds
