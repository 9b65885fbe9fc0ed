"""Helpers of readers of several formats: the frame rate, curves between keys, one curve for each target."""

from __future__ import annotations

from collections.abc import Iterable
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


def sample_tangents(
    grid: NDArray[np.float64],
    times: NDArray[np.float64],
    values: NDArray[np.float64],
    before: NDArray[np.float64],
    after: NDArray[np.float64],
) -> NDArray[np.float64]:
    """A curve of keys, (k,) each, at instants, (frames,): cubic with the slopes before and after each key.

    Where a slope at one end of a span is infinite, the span holds its first value. Times do not decrease; end
    values are held.
    """
    if len(times) == 1:
        return np.full(len(grid), values[0])
    first = np.clip(np.searchsorted(times, grid, "right") - 1, 0, len(times) - 2)
    span = times[first + 1] - times[first]
    share = np.clip((grid - times[first]) / np.where(span > 0, span, 1.0), 0.0, 1.0)
    rise = values[first + 1] - values[first]
    steps = np.isinf(after[first]) | np.isinf(before[first + 1])
    come = np.where(steps, 0.0, after[first]) * span - rise
    go = np.where(steps, 0.0, before[first + 1]) * span - rise
    rest = 1.0 - share
    curve = values[first] + share * rise + share * rest * (rest * come - share * go)
    return np.asarray(np.where(steps & (share < 1.0), values[first], curve))


def rig_of_channels(names: Iterable[str]) -> str:
    """The shipped rig whose spelling the names of channels have, for files that name none."""
    found = set(names)
    if any(name.startswith("CTRL_expressions_") for name in found):
        return "metahuman"
    return "vrm" if {"aa", "ih", "ou"} <= found else "arkit"
