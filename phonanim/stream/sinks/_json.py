"""A stream as JSON texts: one that describes it, then one per frame."""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from phonanim.stream.sinks import Stage

DIGITS = 5  # of a value; controls are in 0..1


def header_text(stage: Stage) -> str:
    """The rig, frames per second, and the names of the controls."""
    return json.dumps({"rig": stage.rig, "fps": stage.fps, "controls": stage.controls})


def frame_text(number: int, time: float, values: NDArray[np.float32]) -> str:
    """The number of a frame, its time in seconds, and the values in the order of the controls."""
    rounded = [round(value, DIGITS) for value in values.tolist()]
    return json.dumps({"frame": number, "time": round(time, 6), "values": rounded})
