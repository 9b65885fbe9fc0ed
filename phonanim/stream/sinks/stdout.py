"""Lines of JSON on stdout: one that describes the stream, then one per frame."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.stream.sinks import Address, Stage
from phonanim.stream.sinks._json import frame_text, header_text

SUMMARY = "lines of JSON: the controls, then frame, time and values"
ADDRESS = None
STDOUT = 1


@dataclass(frozen=True)
class Lines:
    """The open stdout."""

    where: str = "stdout"

    def send(self, number: int, time: float, values: NDArray[np.float32]) -> None:
        """One line."""
        _write(frame_text(number, time, values))

    def close(self) -> None:
        """Do nothing: every line is already written."""


def open_sink(stage: Stage, address: Address | None) -> Lines:
    """Write the first line."""
    _write(header_text(stage))
    return Lines()


def _write(line: str) -> None:
    """Write at once, without Python's buffer, which would raise an error at exit for a closed pipe."""
    data = (line + "\n").encode()
    while data:
        data = data[os.write(STDOUT, data) :]
