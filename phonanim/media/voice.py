"""Level and pitch of a voice from audio samples, 100 frames per second."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

FRAMES = 100  # per second
HALF = 0.02  # seconds to either side of a frame from which its level and pitch are taken
RATE = 4000  # hertz: least rate for the pitch search; more samples are averaged
LOWEST, HIGHEST = 70.0, 400.0  # hertz of speaking voices (Titze 1994, Principles of Voice Production)
VOICED = 0.5  # of the energy that a period must repeat
DIP = 0.3  # of the energy by which a voice is less alike within its period
FLOOR = -55.0  # dB of full scale; less is silence
RANGE = 30.0  # dB below the loudest of the last seconds that is still speech
MEMORY = 3.0  # seconds with which level and pitch are compared
NEAR = 0.08  # seconds to either side of a syllable's peak that must be lower
CLOSE = 12.0  # dB below the loudest of the last seconds within which a syllable may carry an accent
STRONG = 6.0  # semitones of the strongest accent
CHUNK = 2000  # frames at a time
RIPE = 3  # frames that a change of level must last to count


@dataclass(frozen=True)
class Voice:
    """`level` (frames,) in dB of full scale and `pitch` (frames,) in hertz, NaN without voice.

    `tilt` (frames,) is the correlation of neighbouring samples at about RATE: 1 where low frequencies have
    all the energy, 0 in white noise; empty where it is not kept.
    Frame n is at `start` + n / 100 seconds. It becomes known `settled` seconds later.
    """

    level: Array
    pitch: Array
    start: float = 0.0
    tilt: Array = field(default_factory=lambda: np.zeros(0))

    settled = HALF + RIPE / FRAMES

    def active(self) -> NDArray[np.bool_]:
        """Where somebody speaks, (frames,): by the level relative to the loudest of the last seconds."""
        if not len(self.level):
            return np.zeros(0, bool)
        loud = self.level > np.maximum(_trailing_max(self.level, MEMORY) - RANGE, FLOOR)
        steady = np.convolve(loud, np.ones(RIPE), "full")[RIPE - 1 :] >= RIPE  # this frame and the next two
        return np.asarray(np.convolve(steady, np.ones(RIPE), "full")[: len(loud)] > 0)

    def melody(self) -> Array:
        """Semitones above the voice's mean over the last seconds, (frames,); 0 without voice."""
        voiced = np.isfinite(self.pitch)
        height = np.where(voiced, 12 * np.log2(np.where(voiced, self.pitch, 1.0)), 0.0)
        size = round(MEMORY * FRAMES)
        count = np.maximum(_trailing_sum(voiced.astype(float), size), 1)
        return np.where(voiced, height - _trailing_sum(height, size) / count, 0.0)

    def melody_at(self, times: Array) -> Array:
        """The highest melody value within 50 ms of each instant, (times,)."""
        if not len(self.level):
            return np.zeros(len(times))
        padded = np.pad(self.melody(), 5)
        around = np.lib.stride_tricks.sliding_window_view(padded, 11).max(axis=1)
        rows = np.rint((times - self.start) * FRAMES).astype(np.int64)
        return np.asarray(around[np.clip(rows, 0, len(around) - 1)])

    def peaks(self) -> tuple[Array, Array, Array]:
        """Prominent syllables: instants, strengths 0 to 1, and when each becomes known, (peaks,) each."""
        if not len(self.level):
            return np.zeros(0), np.zeros(0), np.zeros(0)
        near = round(NEAR * FRAMES)
        level = np.convolve(np.pad(self.level, 2, "edge"), np.ones(5) / 5, "valid")
        around = np.lib.stride_tricks.sliding_window_view(np.pad(level, near, "edge"), 2 * near + 1)
        loudest = _trailing_max(self.level, MEMORY)
        found = (level >= around.max(axis=1)) & (level > loudest - CLOSE) & self.active()
        rows = np.flatnonzero(found & np.isfinite(self.pitch))
        louder = 1 - (loudest[rows] - level[rows]) / CLOSE
        higher = np.clip(self.melody()[rows] / STRONG, 0.0, 1.0)
        times = self.start + rows / FRAMES
        return times, np.clip(0.5 * louder + 0.6 * higher, 0.0, 1.0), times + NEAR + self.settled + 2 / FRAMES


def analyze_voice(
    samples: Floats, rate: int, first: int = 0, count: int | None = None, dropped: int = 0
) -> Voice:
    """Level and pitch of mono samples in -1..1, (samples,), at `rate` hertz: `count` frames from `first` on.

    `dropped` is the number of samples before the given ones. The pitch of every other frame is the best
    repetition of 40 ms: their autocorrelation divided by that of their window (Boersma 1993, Proceedings of
    the Institute of Phonetic Sciences 17). Boersma's path over frames is left out, so that a frame needs only
    its own 40 ms.
    """
    total = -(-len(samples) * FRAMES // rate) if count is None else first + count
    levels, pitches, tilts = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
    for begin in range(first - first % 2, total, CHUNK):
        numbers = np.arange(begin, min(begin + CHUNK, total))
        cut = _around(samples, np.rint(numbers * rate / FRAMES).astype(np.int64) - dropped, rate)
        level = 10 * np.log10((cut**2).mean(axis=1) + 1e-10)
        pitch = np.full(len(level[::2]), np.nan)
        loud = level[::2] > FLOOR
        pitch[loud] = _pitch(cut[::2][loud], rate / max(1, rate // RATE))
        levels.append(level)
        tilts.append((cut[:, 1:] * cut[:, :-1]).sum(axis=1) / np.maximum((cut**2).sum(axis=1), 1e-12))
        pitches.append(np.repeat(pitch, 2)[: len(level)])
    skipped = first % 2
    level, pitch, tilt = (np.concatenate(parts)[skipped:] for parts in (levels, pitches, tilts))
    return Voice(level, pitch, first / FRAMES, tilt)


def _around(samples: Floats, centres: NDArray[np.int64], rate: int) -> Array:
    """40 ms around each centre at about RATE, (frames, samples); silence beyond the ends."""
    step = max(1, rate // RATE)
    half = round(HALF * rate / step)
    low = int(centres[0]) - half * step
    high = int(centres[-1]) + half * step
    inner = samples[max(low, 0) : max(high, 0)]
    padded = np.pad(inner, (max(-low, 0), max(high - low - len(inner) - max(-low, 0), 0)))
    # The sums over one step may begin at any sample, because the centres do.
    summed = np.cumsum(np.pad(padded.astype(float), (1, 0)))
    rows = (centres - half * step - low)[:, None] + np.arange(2 * half + 1) * step
    edges = summed[rows]
    return np.asarray((edges[:, 1:] - edges[:, :-1]) / step)


def _pitch(cut: Array, rate: float) -> Array:
    """Hertz of the strongest period of each row, NaN where none repeats, (frames, samples) -> (frames,)."""
    size = cut.shape[1]
    window = np.hanning(size)
    cut = (cut - cut.mean(axis=1, keepdims=True)) * window
    length = 1 << (2 * size - 1).bit_length()
    repeats = np.fft.irfft(np.abs(np.fft.rfft(cut, length)) ** 2, length)
    own = np.fft.irfft(np.abs(np.fft.rfft(window, length)) ** 2, length)
    shortest, longest = int(rate / HIGHEST), min(int(rate / LOWEST), int(0.75 * size))
    every = repeats[:, : longest + 1] / (repeats[:, :1] + 1e-9) / (own[: longest + 1] / own[0])
    alike = every[:, shortest:]
    # Choose the shortest of the periods that repeat almost equally well.
    peak = np.zeros(alike.shape, bool)
    peak[:, 1:-1] = (alike[:, 1:-1] >= alike[:, :-2]) & (alike[:, 1:-1] >= alike[:, 2:])
    peak &= alike >= 0.9 * alike.max(axis=1, keepdims=True)
    best = peak.argmax(axis=1)
    rows = np.arange(len(alike))
    before, at, after = (alike[rows, np.clip(best + k, 0, alike.shape[1] - 1)] for k in (-1, 0, 1))
    bend = before - 2 * at + after
    finer = np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, 1.0), 0.0)
    # Rumble below a voice is alike at all short lags; a voice is not within its period.
    least = np.minimum.accumulate(every, axis=1)[rows, best + shortest]
    found = peak.any(axis=1) & (at > VOICED) & (at - least > DIP)
    return np.where(found, rate / (best + finer + shortest), np.nan)


def _trailing_sum(values: Array, size: int) -> Array:
    """Running sums over `size` values that end at each value."""
    total = np.append(0.0, np.cumsum(values))
    return total[1:] - total[np.maximum(np.arange(1, len(values) + 1) - size, 0)]


def _trailing_max(values: Array, seconds: float) -> Array:
    """Running maximum over each value and those of the `seconds` before it."""
    size = round(seconds * FRAMES)
    padded = np.concatenate([np.full(size - 1, -np.inf), values])
    blocks = -(-len(padded) // size) * size
    padded = np.pad(padded, (0, blocks - len(padded)), constant_values=-np.inf).reshape(-1, size)
    ahead = np.maximum.accumulate(padded, axis=1).ravel()
    back = np.maximum.accumulate(padded[:, ::-1], axis=1)[:, ::-1].ravel()
    count = len(values)
    return np.maximum(back[:count], ahead[size - 1 : size - 1 + count])
