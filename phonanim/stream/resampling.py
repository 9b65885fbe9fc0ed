"""Resampling of audio that arrives in pieces."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.encoders import RATE
from phonanim.errors import MissingExtraError

Floats = NDArray[np.float32]


class Resampler:
    """Resample arriving audio of any rate to that of the encoders. Raises MissingExtraError without soxr."""

    def __init__(self, rate: int) -> None:
        self.stream: Any = None
        if rate == RATE:
            return
        try:
            import soxr
        except ImportError as error:
            needed = "pip install 'phonanim[stream]'"
            raise MissingExtraError(f"audio of {rate} Hz needs {needed}, or audio of {RATE} Hz") from error
        self.stream = soxr.ResampleStream(rate, RATE, 1, dtype="float32")

    def push(self, samples: Floats) -> Floats:
        """Samples at the encoders' rate; some are returned later."""
        return np.asarray(self.stream.resample_chunk(samples) if self.stream else samples, np.float32)

    def end(self) -> Floats:
        """The remaining samples."""
        last = np.empty(0, np.float32)
        return np.asarray(self.stream.resample_chunk(last, last=True) if self.stream else last, np.float32)
