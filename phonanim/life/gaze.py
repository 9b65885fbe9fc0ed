"""Gaze: the eyes fixate the listener's eyes and mouth, look away to think, and jump between places.

A saccade of A degrees takes 21 + 2.2 A ms (Carpenter 1988, Movements of the Eyes), which gives peak speeds
of the main sequence (Bahill, Clark and Stark 1975, Mathematical Biosciences 24). Durations, directions and
sizes of looks at the listener and away are of the order that Lee, Badler and Badler 2002 report (Eyes Alive,
SIGGRAPH): 3.1 s and 0.9 s when talking, 7.9 s and 0.4 s when listening, sizes with a decay of 6.9 degrees.
They are quoted from memory; only the paper's abstract was at hand to check them. Speakers begin a
turn with averted gaze and end it with gaze at the listener (Kendon 1967, Acta Psychologica 26; Ho, Foulsham
and Kingstone 2015, PLOS ONE 10(8)). People look at both eyes and mouth (Rogers et al. 2018, Scientific
Reports 8). One or two microsaccades a second stay below half a degree (Martinez-Conde, Macknik and Hubel
2004, Nature Reviews Neuroscience 5).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.life.chance import (
    Index,
    as_lognormal,
    as_normal,
    events,
    lognormal,
    normals,
    number_of,
    uniform,
    uniforms,
)
from phonanim.speech.prosody import Prosody

Array = NDArray[np.float64]

FRONT = (0.0, 0.0, 1.0)  # metres from the speaker's eyes to the listener's: left, up, ahead
EYES_APART, MOUTH_BELOW = 0.063, 0.065  # metres in the listener's face
ON_EYES = 0.7  # share of the fixations of the face that are on the eyes
FIXATION, LEAST = 0.85, 0.25  # seconds of a fixation: mean and minimum
TALK_CYCLE, TALK_AWAY = 4.06, 0.93  # seconds between looks away, and of a look away
LISTEN_CYCLE, LISTEN_AWAY = 8.35, 0.43
LONGEST = 2.5  # seconds of a look away
FALL = 6.9  # degrees over which the frequency of sizes falls to 1/e
SMALLEST, LARGEST = 3.0, 22.0  # degrees of a look away
# Share of each direction, counterclockwise in steps of 45 degrees from the right.
DIRECTIONS = np.array([15.54, 6.46, 17.69, 7.44, 16.80, 7.89, 20.38, 7.79])
UP_TO = np.cumsum(DIRECTIONS) / DIRECTIONS.sum()
TURNED = 0.6  # share of long utterances at whose start the speaker looks away
BEFORE = 0.5  # seconds of silence required before such an utterance
TINY_GAP, TINY = 0.6, 0.25  # seconds between microsaccades, and their degrees
BACK = 4.0  # seconds before an instant that influence where the eyes are


@dataclass(frozen=True)
class Gaze:
    """Where the eyes look, (frames,) degrees to the character's left and up, and their saccades.

    `onsets` (saccades,) seconds and `places` (saccades, 2) degrees are the jumps between places on
    the listener's face and beside it.
    """

    left: Array
    up: Array
    onsets: Array
    places: Array

    @property
    def sizes(self) -> Array:
        """Size of each jump, (saccades,) degrees."""
        return np.asarray(np.hypot(*np.diff(self.places, axis=0, prepend=self.places[:1]).T))


def look(seed: int, prosody: Prosody, times: Array, at: tuple[float, float, float] = FRONT) -> Gaze:
    """Gaze at instants, (frames,) seconds, with the listener's eyes `at` metres from the speaker's."""
    start, end = float(times[0]) - BACK, float(times[-1]) + LEAST
    onsets, targets = _targets(seed, prosody, start, end, at)
    large = _jumps(onsets, targets, times)
    tiny = _jumps(*_tiny(seed, start, end), times)
    left, up = (large + tiny).T
    return Gaze(left, up, onsets, targets)


def direction(at: tuple[float, float, float]) -> tuple[float, float]:
    """Direction of a point in metres, as degrees to the left and up."""
    left, up, ahead = at
    return float(np.degrees(np.arctan2(left, ahead))), float(
        np.degrees(np.arctan2(up, np.hypot(left, ahead)))
    )


def saccade_seconds(degrees: Array) -> Array:
    """Durations of saccades of these sizes, in seconds."""
    return np.asarray(0.021 + 0.0022 * degrees)


def looks_away(seed: int, prosody: Prosody, start: float, end: float) -> tuple[Array, Array]:
    """When the eyes leave the listener and return, (looks,) seconds each, in order and not overlapping."""

    def gap(numbers: Index) -> Array:
        return 1.0 + lognormal(seed, "away gap", numbers, TALK_CYCLE - 1.0, 0.7)

    begins, numbers = events(seed, "away", gap, 1.0, start - LONGEST, end)
    talks = _talking(prosody, begins)
    chosen, *lasting = uniforms(seed, ("away kept", "away lasts", "away lasts turn"), numbers)
    kept = talks | (chosen < TALK_CYCLE / LISTEN_CYCLE)
    lasts = np.where(talks, TALK_AWAY, LISTEN_AWAY) * as_lognormal(as_normal(*lasting), 1.0, 0.5)
    turned = _turned(seed, prosody)
    begins = np.concatenate([begins[kept], turned])
    own = 0.4 + lognormal(seed, "turned lasts", number_of(turned), TALK_AWAY, 0.4)
    lasts = np.clip(np.concatenate([lasts[kept], own]), LEAST, LONGEST)
    order = np.argsort(begins, kind="stable")
    return _apart(begins[order], begins[order] + lasts[order], prosody)


def _talking(prosody: Prosody, times: Array) -> NDArray[np.bool_]:
    begun = np.searchsorted(prosody.starts_from, times) - 1
    ends = np.append(prosody.ends_from, -np.inf)
    return np.asarray(ends[begun] > times)


def _turned(seed: int, prosody: Prosody) -> Array:
    """Times of looks away at the start of long utterances."""
    long = np.isfinite(prosody.long_from) & (prosody.pauses() >= BEFORE)
    begins = prosody.long_from[long]
    return begins[uniform(seed, "turned", number_of(prosody.starts[long])) < TURNED]


def _apart(begins: Array, ends: Array, prosody: Prosody) -> tuple[Array, Array]:
    """Looks away without overlaps, which end soon after a phrase ends."""
    over = np.append(prosody.ends_from, np.inf)
    over = np.maximum(over[np.searchsorted(prosody.ends_from, begins, side="right")], begins + LEAST)
    ends = np.minimum(ends, over)
    before = np.append(-np.inf, np.maximum.accumulate(ends)[:-1]) if len(ends) else ends
    kept = begins > before + LEAST
    return begins[kept], ends[kept]


def _targets(
    seed: int, prosody: Prosody, start: float, end: float, at: tuple[float, float, float]
) -> tuple[Array, Array]:
    """When the eyes move to a new place, (n,) seconds, and the places, (n, 2) degrees to the left and up."""

    def gap(numbers: Index) -> Array:
        return np.minimum(LEAST + lognormal(seed, "fixation", numbers, FIXATION - LEAST, 0.7), LONGEST)

    times, numbers = events(seed, "fixation", gap, LEAST, start, end)
    places = _on_face(seed, numbers, at)
    begins, ends = looks_away(seed, prosody, start, end)
    beyond = _beyond(seed, number_of(begins), at)
    back = places[np.maximum(np.searchsorted(times, ends) - 1, 0)] if len(times) else beyond
    index = np.searchsorted(begins, times, side="right") - 1
    away = (index >= 0) & (times <= np.append(ends, -np.inf)[index] + LEAST)
    onsets = np.concatenate([times[~away], begins, ends])
    targets = np.concatenate([places[~away], beyond, back])
    order = np.argsort(onsets, kind="stable")
    return onsets[order], targets[order]


def _on_face(seed: int, numbers: Index, at: tuple[float, float, float]) -> Array:
    """Places on the listener's face, (n, 2) degrees."""
    distance = math.hypot(*at)
    left, up = direction(at)
    sides, eyes = uniforms(seed, ("side", "eyes"), numbers)
    side, on_eyes = np.where(sides < 0.5, -0.5, 0.5) * EYES_APART, eyes < ON_EYES
    across = np.where(on_eyes, side, 0.0)
    below = np.where(on_eyes, 0.0, MOUTH_BELOW)
    return np.stack([left + np.degrees(across / distance), up - np.degrees(below / distance)], axis=1)


def _beyond(seed: int, numbers: Index, at: tuple[float, float, float]) -> Array:
    """Places beside the listener, (n, 2) degrees."""
    left, up = direction(at)
    drawn = uniforms(seed, ("size", "direction", "direction spread", "direction spread turn"), numbers)
    size = SMALLEST - FALL * np.log(drawn[0])
    size = np.minimum(size, LARGEST)
    turn = np.searchsorted(UP_TO, drawn[1]) * 45.0
    turn = np.radians(turn + 15.0 * as_normal(*drawn[2:]))
    return np.stack([left - size * np.cos(turn), up + 0.6 * size * np.sin(turn)], axis=1)


def _tiny(seed: int, start: float, end: float) -> tuple[Array, Array]:
    """Microsaccades: times (n,) in seconds, and offsets from the fixation (n, 2) in degrees."""

    def gap(numbers: Index) -> Array:
        return 0.2 + lognormal(seed, "tiny", numbers, TINY_GAP - 0.2, 0.5)

    times, numbers = events(seed, "tiny", gap, 0.2, start, end)
    places = normals(seed, ("tiny left", "tiny up"), numbers)
    return times, TINY / 1.8 * np.clip(places.T, -2, 2)


def _jumps(onsets: Array, targets: Array, times: Array) -> Array:
    """The path of a point that jumps to targets, (frames, 2); an unfinished jump adds to the next."""
    if not len(onsets):
        return np.zeros((len(times), 2))
    steps = np.diff(targets, axis=0, prepend=targets[:1])
    lasts = saccade_seconds(np.hypot(*steps.T))
    last = np.searchsorted(onsets, times, side="right") - 1 - np.arange(3)[:, None]
    index = np.maximum(last, 0)
    share = np.clip((times - onsets.take(index)) / lasts.take(index), 0.0, 1.0)
    going = share**3 * (10 + share * (6 * share - 15))
    left = np.where(last >= 0, 1 - going, 0.0)[..., None] * steps.take(index, axis=0)
    place = targets.take(index[0], axis=0)
    for one in left:
        place -= one
    return place
