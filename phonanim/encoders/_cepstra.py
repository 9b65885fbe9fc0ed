"""Mel-frequency cepstral coefficients and their slopes, which need no weights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.encoders import HOP, RATE
from phonanim.media.mel import mel_filters, power_spectra

BINS = 27
FLOOR = 1e-8  # of the power of a full-scale bin, because digital silence has no logarithm
REACH = 2  # steps on each side over which a slope is computed


@dataclass(frozen=True)
class Cepstra:
    """27 cepstral coefficients of windows of `size` samples, optionally with their slopes, one layer."""

    size: int
    sloped: bool
    layers: int = 1
    start: float = 0.0
    window: int = 60
    margin: int = 1

    @property
    def dims(self) -> int:
        """Number of coefficients and slopes."""
        return (1 + self.sloped) * BINS

    @property
    def identity(self) -> str:
        """All settings that the features depend on."""
        return f"mfcc {BINS} of {self.size}, " + (f"slopes over {REACH}" if self.sloped else "no slopes")

    @property
    def reach(self) -> int:
        """Samples to either side of a step's centre that affect it."""
        return self.size // 2 + self.sloped * REACH * HOP

    def run(self, samples: NDArray[np.float32]) -> NDArray[np.float32]:
        """Features of (steps * HOP,) samples -> (steps, 1, dims)."""
        mel = power_spectra(samples, self.size, HOP) @ mel_filters(RATE, self.size, BINS)
        cepstra = np.log(mel + FLOOR) @ _cosines(BINS)
        parts = [cepstra, slopes(cepstra)] if self.sloped else [cepstra]
        return np.column_stack(parts)[:, None].astype(np.float32)


def slopes(curves: NDArray[np.floating]) -> NDArray[np.floating]:
    """Least-squares slope of each curve over 2 * REACH + 1 steps, (steps, n) -> (steps, n) per step."""
    padded = np.pad(curves, ((REACH, REACH), (0, 0)), mode="edge")
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * REACH + 1, axis=0)
    weights = np.arange(-REACH, REACH + 1)
    return np.asarray(around @ (weights / (weights**2).sum()))


def _cosines(count: int) -> NDArray[np.float64]:
    """The orthonormal cosine transform of type II, (count, count)."""
    n = np.arange(count)
    table = np.sqrt(2 / count) * np.cos(np.pi * (n[:, None] + 0.5) * n / count)
    table[:, 0] /= np.sqrt(2)
    return np.asarray(table)
