"""Encoders: convert a recording into audio features, 50 per second. One file each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from phonanim.core.plugins import Registry
from phonanim.encoders._cache import cached_features
from phonanim.errors import AudioError, ModelError
from phonanim.media.audio import Sound, resample

RATE = 16000  # hertz of the audio that every encoder takes
HOP = 320  # samples from one step to the next: 20 ms, as in the papers
STEPS = RATE / HOP  # steps per second

ENCODERS = Registry("phonanim.encoders", needs=("load",))

Array = NDArray[np.float64]
Values = NDArray[np.float16]


@dataclass(frozen=True)
class Features:
    """The output of an encoder: `values` (steps, layers, dims), step k centred at start + k / rate seconds.

    The values of long recordings are in a file and are read on demand.
    """

    values: Values
    rate: float
    start: float

    def at(self, times: Array, span: float = 0.0) -> NDArray[np.float32]:
        """Features at instants, (times,) seconds -> (times, layers, dims); clamped at the ends.

        Interpolated linearly, or the mean over `span` seconds around each instant.
        """
        if span <= 1 / self.rate:
            return self._between(times)
        count = max(2, round(span * self.rate))
        shifts = ((np.arange(count) + 0.5) / count - 0.5) * span
        total = sum(self._between(times + shift) for shift in shifts)
        return np.asarray(total / np.float32(count), np.float32)

    def _between(self, times: Array) -> NDArray[np.float32]:
        place = np.clip((times - self.start) * self.rate, 0, len(self.values) - 1)
        below = np.floor(place).astype(np.int64)
        share = (place - below).astype(np.float32)[:, None, None]
        lower = self.values[below].astype(np.float32)
        upper = self.values[np.minimum(below + 1, len(self.values) - 1)].astype(np.float32)
        return np.asarray(lower + (upper - lower) * share, np.float32)


class Encoder(Protocol):
    """The protocol of what `load()` of each file, or of a plugin of the group `phonanim.encoders`, returns.

    `run` gets at most `window` whole seconds at a time. The features of `margin` whole seconds at each end of
    a window are only context and are dropped. `start` is the centre of the first step in seconds. `identity`
    changes whenever the features change.
    """

    @property
    def layers(self) -> int:
        """Number of layers of features; the last layer of the network comes last."""

    @property
    def dims(self) -> int:
        """Features in each layer."""

    @property
    def identity(self) -> str:
        """A short text that names the encoder, its settings and its weights."""

    @property
    def start(self) -> float:
        """Centre of the first step, seconds."""

    @property
    def window(self) -> int:
        """Seconds encoded at a time."""

    @property
    def margin(self) -> int:
        """Seconds at each end of a window that are only context."""

    def run(self, samples: NDArray[np.float32]) -> NDArray[np.float32]:
        """Features of (steps * HOP,) samples at RATE -> (steps, layers, dims)."""


def encoder_names() -> tuple[str, ...]:
    """Every encoder: the stems of this folder's files, and the plugins."""
    return ENCODERS.names()


def load_encoder(name: str) -> Encoder:
    """An encoder by name, with its weights. Raises ModelError or MissingExtraError, with what to install."""
    found = ENCODERS.find(name)
    if found is None:
        near = get_close_matches(name, encoder_names(), n=1)
        hint = f"; did you mean {near[0]!r}?" if near else "; features of another program are 'precomputed'"
        raise ModelError(f"there is no encoder {name!r}{hint} (known: {', '.join(encoder_names())})")
    return cast("Encoder", found.load())


def encode(encoder: Encoder, sound: Sound) -> Features:
    """Encode a recording of any rate and length; the result is cached on disk.

    Works through windows, so that memory use does not grow with the recording. The same sound and encoder
    give the same bytes. Raises AudioError when the recording is empty or has samples that are not finite.
    """
    check_sound(sound)
    shape = (count_steps(sound), encoder.layers, encoder.dims)
    identity = f"{encoder.identity}, {encoder.window} s at a time, {encoder.margin} s around"
    values = cached_features(identity, sound, shape, _windows(encoder, sound))
    return Features(values, STEPS, encoder.start)


def check_sound(sound: Sound) -> None:
    """Raise AudioError when a recording cannot be encoded."""
    if len(sound.samples) == 0:
        raise AudioError("the recording contains no samples; record it again")
    if not np.isfinite([sound.samples.min(), sound.samples.max()]).all():
        raise AudioError("the recording has samples that are not finite numbers; export it again")


def count_steps(sound: Sound) -> int:
    """Number of steps that cover a recording."""
    return -(-round(sound.duration * RATE) // HOP) or 1  # anything shorter than a step is one step


def _windows(encoder: Encoder, sound: Sound) -> Iterator[NDArray[np.float32]]:
    """Features of consecutive stretches of a recording, each encoded with its context."""
    rate, left = sound.rate, count_steps(sound)
    for begin, first, last in _spans(left / STEPS, encoder.window, encoder.margin):
        samples = resample(sound.samples[begin * rate : (begin + encoder.window) * rate], rate, RATE)
        found = encoder.run(np.pad(samples, (0, -len(samples) % HOP if len(samples) else HOP)))
        fresh = found[round((first - begin) * STEPS) : round((last - begin) * STEPS)][:left]
        left -= len(fresh)
        yield fresh


def _spans(seconds: float, window: int, margin: int) -> Iterator[tuple[int, int, int]]:
    """Start of each window, and the stretch of it that is kept, in whole seconds."""
    begin = first = 0
    while begin + window < seconds:
        last = begin + window - margin
        yield begin, first, last
        begin, first = last - margin, last
    yield begin, first, begin + window
