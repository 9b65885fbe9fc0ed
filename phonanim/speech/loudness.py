"""Loudness: how much louder or softer than usual a line is at each instant, by its recording and its phones.

Articulation follows the level of a phrase, a second and more; energy phone by phone is that of the phones
themselves. Only voiced frames within phones count, which stand out from what is there in pauses: noise and
music do not drive it. A whisper has no such frames, so it is as large as any speech.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.media.voice import FLOOR, FRAMES, Voice
from phonanim.speech.inventory import INVENTORY, SILENCE
from phonanim.speech.phones import PhoneTrack
from phonanim.speech.prosody import VOWELS

Array = NDArray[np.float64]

SIGMA = 0.5  # seconds: the level is that of about a second and a half
LIMIT = 6.0  # dB from the line's own mean, and of this mean from the reference
ABOVE = 6.0  # dB that speech is above what is there in pauses, to count
AWAY = 0.1  # seconds of a pause next to speech that may be speech, since alignments are not exact
SURE = 0.05  # seconds of speech that are needed for half of its level to count
VOICELESS = 0.3  # share of voiced frames in vowels that a whisper does not reach
FLAT = 0.8  # tilt of a whisper at most: its low frequencies are weak, also against those of a creaky voice
NEAR_PEAK = 20.0  # dB below the loudest of a voice that is its speech, where no phones are known
RUN = 6  # voiced frames together; noise is periodic for a few by chance
LEAST = 20  # voiced frames that make a level
SILENT = INVENTORY.code(SILENCE)


@dataclass(frozen=True)
class Loudness:
    """`decibels` (frames,) louder than usual, a hundred times a second from `start` on.

    `mean` is the level of its speech in dB of full scale, NaN where there is none, as in `whispered` lines.
    """

    decibels: Array
    mean: float
    whispered: bool
    start: float = 0.0

    def at(self, times: Array) -> Array:
        """Decibels at instants, (frames,) seconds -> (frames,); the ends hold."""
        if not len(self.decibels):
            return np.zeros(len(times))
        return np.interp(times, self.start + np.arange(len(self.decibels)) / FRAMES, self.decibels)


def measure_loudness(voice: Voice, track: PhoneTrack, reference: float | None = None) -> Loudness:
    """The slow level of a line, about its own mean, or about a reference in dB of full scale."""
    if not len(voice.level):
        return Loudness(np.zeros(0), np.nan, False, voice.start)
    times = voice.start + np.arange(len(voice.level)) / FRAMES
    codes = track.sample(times)
    inside = times < track.duration
    if is_whispered(voice, VOWELS[codes] & inside):
        return Loudness(np.zeros(len(times)), np.nan, True, voice.start)
    pauses = inside & (track.distance_to(track.codes != SILENT, times) >= AWAY)
    spoken = inside & (codes != SILENT)
    counted = spoken & speech_frames(voice, pauses) & (_voicing(voice, VOWELS[codes] & inside) > VOICELESS)
    if counted.sum() < LEAST:
        return Loudness(np.zeros(len(times)), np.nan, False, voice.start)
    mean = float(voice.level[counted].mean())
    decibels = np.clip(_smooth(np.where(counted, voice.level - mean, 0.0), counted), -LIMIT, LIMIT)
    if reference is not None:
        decibels = decibels + np.clip(mean - reference, -LIMIT, LIMIT)
    return Loudness(decibels, mean, False, voice.start)


def speech_level(voice: Voice) -> float:
    """The level of the voiced speech of a recording without phones, dB of full scale; NaN without any."""
    spoken = np.isfinite(voice.pitch) & (voice.level > FLOOR)
    if spoken.sum() < LEAST:
        return np.nan
    levels = voice.level[spoken]
    return float(levels[levels > _ranked(levels, 0.95) - NEAR_PEAK].mean())


def speech_frames(voice: Voice, pauses: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Voiced frames that stand out from what is there in pauses, (frames,)."""
    background = _ranked(voice.level[pauses], 0.75) if pauses.sum() >= LEAST else FLOOR
    return lasting(np.isfinite(voice.pitch), RUN) & (voice.level > max(background + ABOVE, FLOOR))


def lasting(frames: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """The frames that belong to a run of so many, (frames,)."""
    full = np.convolve(frames, np.ones(count), "full")[count - 1 :] > count - 0.5  # runs by their first frame
    return np.asarray(np.convolve(full, np.ones(count), "full")[: len(frames)] > 0.5)


def is_whispered(voice: Voice, vowels: NDArray[np.bool_]) -> bool:
    """Whether vowels, (frames,), are whispered: hardly voiced and flat in spectrum, not merely far away.

    Both tell whispered from soft speech (Zhang and Hansen 2007, Interspeech).
    """
    loud = vowels & (voice.level > FLOOR)
    if loud.sum() < LEAST:
        return False
    voiced = float(np.isfinite(voice.pitch[loud]).mean())
    return voiced < VOICELESS and _ranked(voice.tilt[loud], 0.5) < FLAT


def _ranked(values: Array, share: float) -> float:
    """The value that exceeds such a share of values; NumPy's own quantile takes 15 ms to load."""
    return float(np.sort(values)[int(share * (len(values) - 1))])


def _voicing(voice: Voice, vowels: NDArray[np.bool_]) -> Array:
    """The share of voiced frames in the vowels about each frame; whispered words have few."""
    return _smooth(lasting(np.isfinite(voice.pitch), RUN) & vowels, vowels)


def _smooth(values: NDArray[np.generic], counted: NDArray[np.bool_]) -> Array:
    """Means of values over counted frames about each frame, (frames,), drawn to 0 where few are near."""
    half = round(3 * SIGMA * FRAMES)
    kernel = np.exp(-0.5 * (np.arange(-half, half + 1) / (SIGMA * FRAMES)) ** 2)
    total = np.convolve(values, kernel)[half : half + len(values)]
    return np.asarray(total / (np.convolve(counted, kernel)[half : half + len(values)] + SURE * FRAMES))
