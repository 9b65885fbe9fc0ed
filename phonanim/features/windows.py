"""Sliding windows and their overlap mean, at any output frame rate (Taylor 2017, section 5)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
T = TypeVar("T", bound=np.generic)
# Instants closer than this are equal; half the smallest gap between frames at 24 to 120 fps is much larger.
TICK = 1e-7  # seconds


def sliding_windows(values: NDArray[T], width: int) -> NDArray[T]:
    """Windows of `width` frames around each frame, (frames, ...) -> (frames, width, ...); edges repeat."""
    offsets = np.arange(width) - width // 2
    rows = np.arange(len(values))[:, None] + offsets
    found: NDArray[T] = values[np.clip(rows, 0, len(values) - 1)]
    return found


def overlap_mean(windows: NDArray[np.floating]) -> NDArray[np.floating]:
    """Blend predicted windows, (frames, width, modes) -> (frames, modes).

    Each frame is the plain mean of the windows that cover it: up to `width`, fewer at the ends
    (Taylor 2017, section 5, step 3). Windows of a constant give that constant.
    """
    frames, width = windows.shape[:2]
    total = np.zeros((frames, *windows.shape[2:]), windows.dtype)
    count = np.zeros(frames, windows.dtype)
    for place in range(width):
        shift = place - width // 2
        first, last = max(0, shift), min(frames, frames + shift)
        total[first:last] += windows[first - shift : last - shift, place]
        count[first:last] += 1
    blended: NDArray[np.floating] = total / count.reshape(-1, *[1] * (total.ndim - 1))
    return blended


def predict_at(
    times: Array,
    duration: float,
    step: float,
    width: int,
    predict: Callable[[Array], NDArray[np.float32]],
    chunk: int = 4096,
) -> NDArray[np.float32]:
    """Overlap mean at arbitrary instants, (frames,) seconds -> (frames, modes).

    `predict` maps window centres (n,) in seconds to windows (n, width, modes) whose frames are `step`
    seconds apart. An instant t is covered by the windows centred at t, t ± step, ...; windows centred
    outside 0 to `duration` do not exist, as at the ends of a recording. So the motion is one function of
    continuous time: every frame rate samples it exactly, with as many phases of the model's grid as it
    needs, and two frame rates get equal values at equal instants. Instants before the start and after the
    end are clamped: a video often outlasts its alignment by part of a frame.
    """
    if len(times) == 0:
        return predict(np.zeros(1))[:0, 0]
    times = np.clip(times, 0, duration)
    shifts = (np.arange(width) - width // 2) * step
    pieces = []
    size = max(1, chunk // width)
    for begin in range(0, len(times), size):
        centres = times[begin : begin + size, None] - shifts
        ticks, back = np.unique(np.round(centres / TICK).astype(np.int64), return_inverse=True)
        windows = predict(np.asarray(ticks * TICK))
        chosen = windows[back.reshape(centres.shape), np.arange(width)]
        valid = (centres >= -TICK) & (centres <= duration + TICK)
        weights = (valid / np.maximum(valid.sum(axis=1, keepdims=True), 1)).astype(np.float32)
        pieces.append(np.einsum("fw,fwm->fm", weights, chosen))
    return np.concatenate(pieces)
