"""Degrade recordings: noise, babble, and a shifted voice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from phonanim.media.audio import Sound, resample

Samples = NDArray[np.float32]
HOP = 0.015  # seconds between pieces of a stretched voice, half a piece: one or two periods of the voice
SEARCH = 0.008  # seconds to either side in which the best continuation of the last piece is searched
QUIET = 1e-9  # of full scale squared, to avoid a division by zero in silence


def white_noise(length: int, rng: np.random.Generator) -> Samples:
    """White noise, (length,)."""
    return rng.standard_normal(length).astype(np.float32)


def babble_noise(voices: Sequence[Sound], length: int, rate: int, rng: np.random.Generator) -> Samples:
    """Mix several recordings at equal loudness, each from a random position, repeated, -> (length,)."""
    total = np.zeros(length, np.float32)
    for voice in voices:
        samples = resample(voice.samples, voice.rate, rate)
        begin = int(rng.integers(len(samples)))
        total += np.resize(np.roll(samples, -begin), length) / np.sqrt(_power(samples) + QUIET)
    return total


def mix_noise(sound: Sound, noise: Samples, snr: float, spoken: NDArray[np.bool_]) -> Sound:
    """Add noise (samples,) to a recording at `snr` dB below its level in `spoken` samples, (samples,).

    If the result is beyond full scale, all of it is scaled down.
    """
    speech = sound.samples[spoken] if spoken.any() else sound.samples
    gain = np.sqrt(_power(speech) / ((_power(noise) + QUIET) * 10 ** (snr / 10)))
    samples = sound.samples + np.float32(gain) * noise
    return Sound(samples / max(1.0, float(np.abs(samples).max())), sound.rate)


def shift_voice(sound: Sound, semitones: float) -> Sound:
    """The voice with its pitch and its formants times 2 ** (semitones / 12), at the same length.

    The recording is resampled, then stretched back. It sounds like a larger or smaller speaker, which is most
    of the difference between voices; the accent, the timing and everything else stay the same.
    """
    rate = round(sound.rate / 2 ** (semitones / 12))
    played = resample(sound.samples, sound.rate, rate)
    return Sound(stretch_time(played, len(sound.samples), sound.rate), sound.rate)


def stretch_time(samples: Samples, length: int, rate: int) -> Samples:
    """Samples at another speed and the same pitch, (n,) -> (length,).

    Waveform similarity overlap-add (Verhelst and Roelands 1993): instant t of the result is instant
    t * n / length of the input, to within SEARCH.
    """
    hop, search = round(HOP * rate), round(SEARCH * rate)
    window = np.hanning(2 * hop + 1)[:-1].astype(np.float32)
    pieces = -(-length // hop) + 1
    padded = np.pad(samples, (hop + search, 3 * hop + search))
    found = np.zeros((pieces + 1) * hop, np.float32)
    follows = None  # the samples after the last piece, in the input
    for number in range(pieces):
        ideal = min(round(number * hop * len(samples) / length), len(samples))
        near = padded[ideal : ideal + 2 * (hop + search)]
        begin = search if follows is None else int(np.argmax(_alike(near, follows)))
        found[number * hop : (number + 2) * hop] += window * near[begin : begin + 2 * hop]
        follows = padded[ideal + begin + hop :][: 2 * hop]
    return found[hop : hop + length]


def _alike(near: Samples, piece: Samples) -> NDArray[np.floating]:
    """Correlation of a piece with every stretch of its length, divided by the stretch's loudness."""
    energy = np.concatenate([[0.0], np.cumsum(near.astype(np.float64) ** 2)])
    loudness = energy[len(piece) :] - energy[: -len(piece)]
    found: NDArray[np.floating] = np.correlate(near, piece, "valid") / np.sqrt(loudness + QUIET)
    return found


def _power(samples: Samples) -> float:
    return float(np.mean(samples.astype(np.float64) ** 2))
