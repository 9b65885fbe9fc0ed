"""Helpers of readers of several formats: the frame rate of times, one curve for each target."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError
from phonanim.errors import OutputError

DIFFERENT = 1e-3  # of full weight


def merge_target_curves(
    known: NDArray[np.floating] | None, curve: NDArray[np.floating], name: str, path: Path
) -> NDArray[np.floating]:
    """The common curve of a target that several meshes have. Raises OutputError when they differ."""
    if known is None or not known.any():
        return curve
    if curve.any() and np.abs(curve - known).max() > DIFFERENT:
        raise OutputError(
            f"{path}: two of its meshes move {name} differently; "
            "key them alike, or export the changed one by itself"
        )
    return known


USUAL_RATES = (24000 / 1001, 24.0, 25.0, 30000 / 1001, 30.0, 48.0, 50.0, 60000 / 1001, 60.0, 90.0, 120.0)
RATE_TOLERANCE = 5e-4  # timecodes have a resolution of a thousandth of a frame


def estimate_rate(times: NDArray[np.float64]) -> float:
    """Frames per second of rising times, rounded to a common rate if one is near. Raises DecodeError."""
    step = float(np.median(np.diff(times)))
    if not step > 0:
        raise DecodeError("its keys are all at one instant")
    rate = 1 / step
    nearest = min(USUAL_RATES, key=lambda usual: abs(usual - rate))
    return nearest if abs(nearest - rate) < RATE_TOLERANCE * rate else rate
