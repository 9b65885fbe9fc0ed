"""Mel spectra: the power of short stretches of audio in bands of the mel scale."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]


def power_spectra(samples: Floats, size: int, hop: int) -> Floats:
    """Power spectra of Hann windows centred at n * hop, (samples,) -> (frames, size // 2 + 1).

    The sound is mirrored at its ends; there are len(samples) // hop frames.
    """
    mode = "reflect" if len(samples) > size // 2 else "symmetric"
    padded = np.pad(samples, size // 2, mode=mode)  # type: ignore[call-overload]
    frames = np.lib.stride_tricks.sliding_window_view(padded, size)[: len(samples) // hop * hop : hop]
    hann = np.hanning(size + 1)[:-1]
    return np.asarray(np.abs(np.fft.rfft(frames * hann)) ** 2, np.float32)


def mel_filters(rate: int, size: int, count: int) -> Floats:
    """Triangles of equal area on Slaney's mel scale, (size // 2 + 1, count), from 0 to rate / 2 hertz."""
    edges = _hertz(np.linspace(0, _mel(rate / 2), count + 2))
    bins = np.fft.rfftfreq(size, 1 / rate)[:, None]
    rising = (bins - edges[:-2]) / (edges[1:-1] - edges[:-2])
    falling = (edges[2:] - bins) / (edges[2:] - edges[1:-1])
    area = 2 / (edges[2:] - edges[:-2])
    return np.asarray(np.maximum(np.minimum(rising, falling), 0) * area, np.float32)


# Slaney (1998, Auditory Toolbox): linear up to 1000 Hz, 15 mels; beyond, 27 mels for each factor of 6.4.
_STEP = np.log(6.4) / 27


def _mel(hertz: float) -> float:
    return hertz * 3 / 200 if hertz < 1000 else 15 + float(np.log(hertz / 1000)) / _STEP


def _hertz(mels: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(mels < 15, mels * 200 / 3, 1000 * np.exp((mels - 15) * _STEP))


RANGE = 8.0  # powers of ten below the loudest bin; quieter bins are clamped
QUIETEST = 1e-10  # power


def whisper_mel(samples: Floats, bands: int) -> Floats:
    """The input of Whisper (Radford et al. 2022), (samples,) at 16 kHz -> (frames, bands) at 100 Hz."""
    mel = power_spectra(samples, 400, 160) @ mel_filters(16000, 400, bands)
    decades = np.log10(np.maximum(mel, QUIETEST))
    return np.asarray((np.maximum(decades, decades.max() - RANGE) + 4) / 4, np.float32)
