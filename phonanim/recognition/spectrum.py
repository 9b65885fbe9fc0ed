"""The input of the network: mel spectra, less the mean spectrum of the voice so far.

The mean follows the speech so far, so that microphone, room, loudness and much of the voice drop out
(cepstral mean normalization, Atal 1974, made causal). Nothing here looks ahead beyond half a window.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from phonanim.media.mel import mel_filters

Floats = NDArray[np.float32]

RATE, HOP, WINDOW = 16000, 160, 400  # hertz, and samples of 10 ms and of 25 ms
STEP = HOP / RATE  # seconds
BANDS = 40
FLOOR = 1e-9  # of the power of a band
QUIET = -9.0  # nats of power below which nothing counts as speech
FALL = 0.003  # nats that the peak falls at each step
SPEECH, SLOPE = 6.0, 2.0  # nats below the peak at which a step counts as speech, and over which it does
PRIOR, MEMORY = 50.0, 800.0  # steps of speech that the usual spectrum counts for, and that are remembered
START = 4.0  # nats below the loudest step of a whole recording at which its peak begins
PIECE = 10 * RATE  # samples that are analysed at once
LOWEST, HIGHEST, SCALE = -8.0, 6.0, 2.0  # nats from the mean, and the unit of the network's input
USUAL = np.linspace(0.5, -4.0, BANDS, dtype=np.float32) - 2.5  # of speech, in nats below the peak


@dataclass
class MelSpectrum:
    """Log power of mel bands of sound that arrives in pieces, (steps, BANDS); step n is centred at n * STEP.

    Before and after the sound is silence.
    """

    samples: Floats = field(default_factory=lambda: np.zeros(WINDOW // 2, np.float32))
    filters: Floats = field(default_factory=lambda: mel_filters(RATE, WINDOW, BANDS))
    hann: Floats = field(default_factory=lambda: np.hanning(WINDOW + 1)[:-1].astype(np.float32))

    def push(self, samples: Floats) -> Floats:
        """Add samples at RATE, (n,); the steps that they complete."""
        self.samples = np.concatenate([self.samples, samples])
        count = max((len(self.samples) - WINDOW) // HOP + 1, 0)
        if count == 0:
            return np.empty((0, BANDS), np.float32)
        frames = np.lib.stride_tricks.sliding_window_view(self.samples, WINDOW)[: count * HOP : HOP]
        power = (np.abs(np.fft.rfft(frames * self.hann)) ** 2).astype(np.float32)
        self.samples = self.samples[count * HOP :]
        return log_bands(power, self.filters)


def log_bands(power: Floats, filters: Floats) -> Floats:
    """Power spectra (..., steps, bins) -> nats of bands (..., steps, bands), alike for one step or many."""
    return np.log(np.matmul(power[..., None, :], filters)[..., 0, :] + np.float32(FLOOR))


@dataclass
class VoiceMean:
    """The running mean spectrum of a voice. Leading dimensions are voices that are read side by side."""

    shape: tuple[int, ...] = ()
    total: Floats = field(init=False)
    count: Floats = field(init=False)
    peak: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.total = np.zeros((*self.shape, BANDS), np.float32)
        self.count = np.zeros((*self.shape, 1), np.float32)
        self.peak = np.full((*self.shape, 1), QUIET, np.float32)

    def subtract(self, bands: Floats) -> Floats:
        """Log power (..., steps, BANDS) -> the network's input, (..., steps, BANDS)."""
        levels = np.log(np.exp(bands).mean(axis=-1, keepdims=True))
        found = np.empty_like(bands)
        for step in range(bands.shape[-2]):
            here, level = bands[..., step, :], levels[..., step, :]
            self.peak = np.maximum(np.maximum(self.peak - np.float32(FALL), level), np.float32(QUIET))
            weight = np.clip((level - self.peak + np.float32(SPEECH)) / np.float32(SLOPE), 0, 1)
            kept = 1 - weight / np.float32(MEMORY)
            self.total = self.total * kept + weight * here
            self.count = self.count * kept + weight
            mean = (self.total + PRIOR * (USUAL + self.peak)) / (self.count + PRIOR)
            found[..., step, :] = here - mean
        return np.clip(found, LOWEST, HIGHEST) / np.float32(SCALE)


def voice_mean(samples: Floats) -> VoiceMean:
    """The mean of a whole recording at its start, (n,) at RATE: noise before the speech is no speech."""
    power, mean = MelSpectrum(), VoiceMean()
    for begin in range(0, len(samples), PIECE):
        bands = power.push(samples[begin : begin + PIECE])
        if len(bands):
            loudest = np.log(np.exp(bands).mean(axis=-1)).max() - np.float32(START)
            mean.peak = np.maximum(mean.peak, loudest)
    return mean
