"""Made-up voices that say m and aa in turn: voiced, and whispered."""

from __future__ import annotations

import numpy as np
from speech import track_of

RATE = 16000
TRACK = track_of("sil 0.5 " + "m 0.1 aa 0.2 " * 20 + "sil 0.5")
TIMES = np.arange(round(TRACK.duration * RATE)) / RATE
SPOKEN = TRACK.sample(TIMES) != 0


def resonate(source: np.ndarray) -> np.ndarray:
    """The resonances of an open vowel."""
    spectrum = np.fft.rfft(source)
    hertz = np.fft.rfftfreq(len(source), 1 / RATE)
    gain = sum(1 / (1 + ((hertz - f) / 90) ** 2) for f in (750.0, 1250.0, 2600.0))
    return np.fft.irfft(spectrum * gain, len(source))


def voiced() -> np.ndarray:
    pulses = (np.diff(np.floor(TIMES * 120), prepend=0) > 0).astype(float)
    slope = np.fft.irfft(np.fft.rfft(pulses) / (1 + np.fft.rfftfreq(len(TIMES), 1 / RATE) / 200), len(TIMES))
    return scaled(resonate(slope) * SPOKEN, 0.1)


def whispered() -> np.ndarray:
    noise = np.random.default_rng(0).normal(size=len(TIMES))
    bright = np.diff(resonate(noise), prepend=0)
    return scaled(bright * SPOKEN, 0.02)


def scaled(sound: np.ndarray, level: float) -> np.ndarray:
    return sound * level / np.sqrt((sound[SPOKEN] ** 2).mean())
