"""A recording in windows that are cut where it is quiet, read one after the other in little memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.media.audio import Sound, open_audio

LONGEST, EARLIEST = 30.0, 20.0  # seconds of a window, and after which it may be cut
STEP = 0.2  # seconds over which it is quiet
READ = 5.0  # seconds that are read at a time


def quiet_windows(path: Path) -> Iterator[tuple[float, Sound]]:
    """The begin in seconds and the sound of each window, of at most 30 s, of a recording of any length.

    Raises AudioError.
    """
    rate, blocks = open_audio(path, READ)
    return cut(blocks, rate)


def cut(blocks: Iterable[NDArray[np.float32]], rate: int) -> Iterator[tuple[float, Sound]]:
    """The windows of samples that come in blocks, (n,) each, at `rate` hertz."""
    longest = round(LONGEST * rate)
    begin, held = 0, np.zeros(0, np.float32)
    for block in blocks:
        held = np.concatenate([held, block])
        while len(held) > longest:
            end = _quietest(held, round(EARLIEST * rate), longest, round(STEP * rate))
            yield begin / rate, Sound(held[:end], rate)
            begin, held = begin + end, held[end:]
    if len(held):
        yield begin / rate, Sound(held, rate)


def _quietest(samples: NDArray[np.float32], first: int, last: int, step: int) -> int:
    """The middle of the quietest stretch of `step` samples between two samples."""
    piece = samples[first:last]
    power = (piece[: len(piece) // step * step].reshape(-1, step) ** 2).mean(axis=1)
    return first + int(power.argmin()) * step + step // 2
