"""Encoders: a recording in, features of its sound out, 50 times a second. One file each."""

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

RATE = 16000  # hertz that every encoder hears
HOP = 320  # samples from one step to the next: 20 ms, as in the papers
STEPS = RATE / HOP  # steps a second

ENCODERS = Registry("phonanim.encoders", needs=("load",))

Array = NDArray[np.float64]
Values = NDArray[np.float16]


@dataclass(frozen=True)
class Features:
    """What an encoder hears: `values` (steps, layers, dims), step k centred at start + k / rate seconds.

    Values of long recordings lie in a file and are read as they are asked for.
    """

    values: Values
    rate: float
    start: float

    def at(self, times: Array, span: float = 0.0) -> NDArray[np.float32]:
        """Features at instants, (times,) seconds -> (times, layers, dims); the ends repeat.

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
    """What `load()` of each file, or of a plugin of the group `phonanim.encoders`, returns.

    `run` sees at most `window` whole seconds at a time. `margin` whole seconds at each end of a
    window are heard and then left out, `start` is the centre of the first step in seconds, `identity`
    changes whenever the features would.
    """

    @property
    def layers(self) -> int:
        """How many layers of features there are, the last one last."""

    @property
    def dims(self) -> int:
        """Features in each layer."""

    @property
    def identity(self) -> str:
        """The encoder, its settings and its weights in a few words and digits."""

    @property
    def start(self) -> float:
        """Centre of the first step, seconds."""

    @property
    def window(self) -> int:
        """Seconds heard at a time."""

    @property
    def margin(self) -> int:
        """Seconds at each end of a window that only give context."""

    def run(self, samples: NDArray[np.float32]) -> NDArray[np.float32]:
        """Features of (steps * HOP,) samples at RATE -> (steps, layers, dims)."""


def encoder_names() -> tuple[str, ...]:
    """Every encoder: the stems of this folder's files."""
    return ENCODERS.names()


def load_encoder(name: str) -> Encoder:
    """An encoder by name, with its weights. Raises ModelError, MissingExtraError; each says what to get."""
    found = ENCODERS.find(name)
    if found is None:
        near = get_close_matches(name, encoder_names(), n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise ModelError(f"there is no encoder {name!r}{hint} (known: {', '.join(encoder_names())})")
    return cast("Encoder", found.load())


def encode(encoder: Encoder, sound: Sound) -> Features:
    """Hear a recording, of any rate and length; kept on disk, so that it is heard once.

    Works through windows, so that memory does not grow with the recording. The same sound and encoder
    give the same bytes. Raises AudioError when the recording holds nothing, or no numbers.
    """
    check_sound(sound)
    shape = (count_steps(sound), encoder.layers, encoder.dims)
    heard = f"{encoder.identity}, {encoder.window} s at a time, {encoder.margin} s around"
    values = cached_features(heard, sound, shape, _windows(encoder, sound))
    return Features(values, STEPS, encoder.start)


def check_sound(sound: Sound) -> None:
    """Raise AudioError when a recording cannot be heard."""
    if len(sound.samples) == 0:
        raise AudioError("the recording holds no sound; record it again")
    if not np.isfinite([sound.samples.min(), sound.samples.max()]).all():
        raise AudioError("the recording holds samples that are no numbers; export it again")


def count_steps(sound: Sound) -> int:
    """Steps that cover a recording."""
    return -(-round(sound.duration * RATE) // HOP) or 1  # whatever is shorter than a step is one


def _windows(encoder: Encoder, sound: Sound) -> Iterator[NDArray[np.float32]]:
    """Features of consecutive stretches of a recording, each heard with what is around it."""
    rate, left = sound.rate, count_steps(sound)
    for begin, first, last in _spans(left / STEPS, encoder.window, encoder.margin):
        heard = resample(sound.samples[begin * rate : (begin + encoder.window) * rate], rate, RATE)
        found = encoder.run(np.pad(heard, (0, -len(heard) % HOP if len(heard) else HOP)))
        fresh = found[round((first - begin) * STEPS) : round((last - begin) * STEPS)][:left]
        left -= len(fresh)
        yield fresh


def _spans(seconds: float, window: int, margin: int) -> Iterator[tuple[int, int, int]]:
    """Where each window begins, and the stretch of it that is kept, in whole seconds."""
    begin = first = 0
    while begin + window < seconds:
        last = begin + window - margin
        yield begin, first, last
        begin, first = last - margin, last
    yield begin, first, begin + window
