"""Head: nods at accents, turns with phrases and gaze, slow drift, and return to rest at the end.

Heads move with pitch and loudness (Munhall et al. 2004, Psychological Science 15(2)), nod at stressed
syllables and change posture at boundaries (Hadar et al. 1984, Human Movement Science 3; Graf, Cosatto,
Strom and Huang 2002, Visual Prosody). Amplitudes stay below those of lively speakers (Busso et al. 2007, IEEE
Transactions on Audio, Speech and Language Processing 15(3)). The head follows part of a large gaze shift
(Freedman 2008, Experimental Brain Research 190, a review); shares, sizes and delays are set by eye. Monkeys
keep the head still below 20 degrees (Freedman and Sparks 1997, Journal of Neurophysiology 77).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.life.chance import as_lognormal, as_normal, normals, number_of, uniforms, wander
from phonanim.life.shapes import bumps
from phonanim.media.voice import Voice
from phonanim.speech.prosody import Prosody, eased

Array = NDArray[np.float64]

DRIFT = (0.8, 1.3, 0.7)  # degrees of pitch, yaw and roll that the head drifts
PERIODS = (2.6, 3.4, 4.1)  # seconds in which each turns
QUIET = 0.45  # share of the drift that remains in silence
NODDED = 0.8  # share of accents at which the head nods
NOD, MORE = 0.6, 2.0  # degrees of a nod, and more for a strong accent
LEAD = 0.14  # seconds before the middle of the vowel at which a nod begins
POSTURE = (1.0, 2.2, 1.2)  # degrees of pitch, yaw and roll of the posture at the start of a phrase
TAKES, KEEPS, LEAVES = 0.5, 1.2, 1.8  # seconds to reach a posture, to hold it, to leave it
BOW = 1.2  # degrees that the head lowers as a phrase ends
TURN = 0.2  # share of a look away that the head follows
SLOW = 0.45  # seconds of that motion
TUNE = 0.22  # degrees up for each semitone of pitch
STEPS = 0.02  # seconds between the points of the smoothed pitch
SMOOTH = 0.3  # seconds of pitch that count as one motion
LIMIT = 9.0  # largest head turn, in degrees


@dataclass(frozen=True)
class Turns:
    """Degrees of the head, (frames,) each: `pitch` down, `yaw` to its left, `roll` to its right shoulder."""

    pitch: Array
    yaw: Array
    roll: Array

    def scaled(self, gain: Array) -> Turns:
        """The turns scaled by a factor at each frame."""
        return Turns(self.pitch * gain, self.yaw * gain, self.roll * gain)


def turn(
    seed: int, prosody: Prosody, times: Array, shifts: tuple[Array, Array], towards: tuple[float, float]
) -> Turns:
    """The turns of the head at instants; `shifts` are gaze onsets and places (n, 2), degrees left and up.

    `towards` is the direction of the listener, in degrees to the left and up.
    """
    calm = QUIET + (1 - QUIET) * prosody.speaking(times)
    axes = [
        size * calm * wander(seed, f"drift {axis}", times, period) + posture
        for axis, size, period, posture in zip(
            "pyr", DRIFT, PERIODS, _posture(seed, prosody, times), strict=True
        )
    ]
    follow = _follow(*shifts, times, towards)
    pitch = (
        axes[0]
        + _nods(seed, prosody, times)
        + _bows(prosody, times)
        - follow[:, 1]
        - tune(prosody.voice, times)
    )
    return Turns(*(LIMIT * np.tanh(axis / LIMIT) for axis in (pitch, axes[1] + follow[:, 0], axes[2])))


def _nods(seed: int, prosody: Prosody, times: Array) -> Array:
    numbers = number_of(prosody.accents)
    drawn = uniforms(seed, ("nodded", "nod", "nod rise", "nod fall", "nod fall turn"), numbers)
    kept = drawn[0] < NODDED
    high, rising, *falling = drawn[1:, kept]
    onsets = np.maximum(prosody.accents[kept] - LEAD, prosody.accents_from[kept])
    heights, rises = NOD + MORE * prosody.strengths[kept] * high, 0.12 + 0.08 * rising
    falls = as_lognormal(as_normal(*falling), 0.32, 0.2)
    return bumps(times, onsets, rises, np.full(len(rises), 0.02), falls, heights)


def _posture(seed: int, prosody: Prosody, times: Array) -> Array:
    """The posture at the start of each phrase, (3, frames) degrees of pitch, yaw and roll.

    It is held and then left; the next one takes over smoothly.
    """
    drawn = normals(seed, ("posture p", "posture y", "posture r"), number_of(prosody.starts))
    heights = np.array(POSTURE)[:, None] * np.clip(drawn, -2, 2)
    onsets = np.maximum(prosody.starts - 0.2, prosody.starts_from)
    total = np.zeros((3, len(times)))
    seen = (onsets <= times[-1:]) & (onsets + TAKES + KEEPS + LEAVES >= times[:1])
    for onset, height in zip(onsets[seen], heights.T[seen], strict=True):
        end = onset + TAKES + KEEPS + LEAVES
        # Before, nothing changes; after, no earlier posture is left.
        part = slice(*np.searchsorted(times, (onset, end)))
        taken = eased((times[part] - onset) / TAKES)
        leaving = eased((end - times[part]) / LEAVES)
        total[:, part] += taken * (height[:, None] * leaving - total[:, part])
    return total


def _bows(prosody: Prosody, times: Array) -> Array:
    """The head lowers a little at the end of a phrase, and rises again."""
    known = np.isfinite(prosody.ends)
    onsets = prosody.ends_from[known]
    each = np.ones(len(onsets))
    return bumps(times, onsets, 0.35 * each, 0.15 * each, 0.8 * each, BOW * each)


def _follow(onsets: Array, places: Array, times: Array, towards: tuple[float, float]) -> Array:
    """The part of gaze that the head follows, (frames, 2) degrees to the left and up."""
    total = np.tile(np.array(towards) * 0.6, (len(times), 1))
    if not len(onsets):
        return total
    taken = TURN * np.where(np.abs(places - towards) > 5.0, places - towards, 0.0)
    last = np.searchsorted(onsets, times, side="right") - 1 - np.arange(6)[:, None]
    steps = np.diff(taken, axis=0, prepend=taken[:1])
    index = np.maximum(last, 0)
    total += taken.take(index[0], axis=0)
    left = 1 - eased((times - onsets.take(index) - 0.05) / SLOW)
    for one in np.where(last >= 0, left, 0.0)[..., None] * steps.take(index, axis=0):
        total -= one
    return total


def tune(voice: Voice | None, times: Array) -> Array:
    """Degrees up with the pitch of the voice, where there is audio."""
    if voice is None or not len(voice.level):
        return np.zeros(len(times))
    melody = np.clip(voice.melody(), -8, 8)
    size = round(SMOOTH * 100)
    # The mean of recent pitch, so that only the past has an influence.
    summed = np.cumsum(np.pad(melody, (2 * size, 0)))
    mean = (summed[size:] - summed[:-size]) / size
    smooth = np.cumsum(np.pad(mean, (1, 0)))
    double = (smooth[size:] - smooth[:-size]) / size
    curve = double[-len(melody) :]
    return TUNE * np.interp(times, voice.start + np.arange(len(curve)) / 100, curve)
