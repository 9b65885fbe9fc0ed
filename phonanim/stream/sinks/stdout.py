"""Lines of JSON on stdout: one that describes the stream, then one per frame."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.stream.sinks import Address, Stage

SUMMARY = "lines of JSON: the controls, then frame, time and values"
ADDRESS = None
DIGITS = 5  # of a value; controls are in 0..1
STDOUT = 1


@dataclass(frozen=True)
class Lines:
    """The open stdout."""

    where: str = "stdout"

    def send(self, number: int, time: float, values: NDArray[np.float32]) -> None:
        """One line."""
        rounded = [round(value, DIGITS) for value in values.tolist()]
        _write(json.dumps({"frame": number, "time": round(time, 6), "values": rounded}))

    def close(self) -> None:
        """Do nothing: every line is already written."""


def open_sink(stage: Stage, address: Address | None) -> Lines:
    """Write the first line."""
    _write(json.dumps({"rig": stage.rig, "fps": stage.fps, "controls": stage.controls}))
    return Lines()


def _write(line: str) -> None:
    """Write at once, without Python's buffer, which would raise an error at exit for a closed pipe."""
    data = (line + "\n").encode()
    while data:
        data = data[os.write(STDOUT, data) :]
