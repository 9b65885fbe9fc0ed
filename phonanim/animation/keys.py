"""Reduce a curve to few keys within a given error: linear spans between frames of the curve itself.

The spans are linear because every program interpolates them in the same way. Blender drops the tangents of
glTF's cubic keys on import, and cubic spans with the curve's slopes needed no fewer keys on a real capture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation

FIRST_LOOK = 16  # frames; doubled until a key is found


@dataclass(frozen=True)
class Keys:
    """Curves as keys: at `frames` (k,) they have `values` (k, curves), and are linear between.

    `error` is the largest distance to the dense curves at their frames.
    """

    frames: NDArray[np.int64]
    values: NDArray[np.float64]
    error: float

    def sample(self, frames: NDArray[np.float64]) -> NDArray[np.float64]:
        """The curves at frames, which may be fractional: (n,) -> (n, curves); end values are held."""
        return np.stack([np.interp(frames, self.frames, curve) for curve in self.values.T], axis=1)


def reduce_curves(curves: NDArray[np.floating], tolerance: float) -> Keys:
    """Keys shared by all curves, (frames, curves), with an error of at most `tolerance` at every frame.

    Each key is the last frame that a straight line from the one before can reach. Raises ValueError when
    there are no frames.
    """
    dense = np.asarray(curves, np.float64)
    if len(dense) == 0:
        raise ValueError("curves of no frames have no keys")
    places = [0]
    while places[-1] < len(dense) - 1:
        places.append(_farthest(dense, places[-1], tolerance))
    frames = np.array(places, np.int64)
    keys = Keys(frames, dense[frames], 0.0)
    return Keys(frames, keys.values, _largest(keys.sample(np.arange(len(dense), dtype=float)) - dense))


def reduce_channels(animation: Animation, tolerance: float) -> dict[str, Keys]:
    """Keys of each channel separately; a constant channel has one key."""
    return {name: reduce_curve(animation.channel(name), tolerance) for name in animation.channels}


def reduce_curve(curve: NDArray[np.floating], tolerance: float) -> Keys:
    """Keys of one curve, (frames,); one key where it stays within `tolerance` of its first value."""
    dense = np.asarray(curve, np.float64)[:, None]
    error = _largest(dense - dense[0])
    if error <= tolerance:
        return Keys(np.zeros(1, np.int64), dense[:1], error)
    frames = _single(dense[:, 0], tolerance)
    keys = Keys(frames, dense[frames], 0.0)
    return Keys(frames, keys.values, _largest(keys.sample(np.arange(len(dense), dtype=float)) - dense))


def describe_keys(keys: dict[str, Keys], animation: Animation) -> str:
    """Keys per second and largest error of curves with separate keys, as text."""
    moving = [item for item in keys.values() if len(item.frames) > 1]
    count = sum(len(item.frames) for item in moving)
    rate = count / max(len(moving), 1) / (len(animation.values) / animation.fps)
    error = max((item.error for item in keys.values()), default=0.0)
    return (
        f"{count} keys in {len(moving)} moving curves, {rate:.1f} per second each, largest error {error:.4f}"
    )


def describe_shared_keys(keys: Keys, animation: Animation) -> str:
    """The same for curves that share their keys."""
    count = len(keys.frames)
    rate = count / (len(animation.values) / animation.fps)
    return f"{count} keys that all curves share, {rate:.1f} per second, largest error {keys.error:.4f}"


def _largest(differences: NDArray[np.float64]) -> float:
    return float(np.abs(differences).max(initial=0.0))


def _farthest(dense: NDArray[np.float64], first: int, tolerance: float) -> int:
    """The last frame to which straight lines from frame `first` stay within the tolerance of all curves.

    Every frame on the way allows a cone of slopes. A frame can be a key while its slope is within the cones
    of all frames before it. The search ends when the cones have no common slope.
    """
    ahead = FIRST_LOOK
    while True:
        last = min(first + ahead, len(dense) - 1)
        steps = np.arange(1, last - first + 1)[:, None]
        rise = dense[first + 1 : last + 1] - dense[first]
        low = np.maximum.accumulate((rise - tolerance) / steps)
        high = np.minimum.accumulate((rise + tolerance) / steps)
        closed = np.flatnonzero((low > high).any(axis=1))
        if len(closed) or last == len(dense) - 1:
            break
        ahead *= 2
    slopes = rise[1:] / steps[1:]
    fits = ((slopes >= low[:-1]) & (slopes <= high[:-1])).all(axis=1)
    reached = np.flatnonzero(fits[: closed[0]] if len(closed) else fits)
    return first + 2 + int(reached[-1]) if len(reached) else first + 1


def _single(curve: NDArray[np.float64], tolerance: float) -> NDArray[np.int64]:
    """The keys of one curve, (frames,), as `_farthest` finds them; for one curve a plain loop is faster."""
    values = curve.tolist()
    places, last = [0], len(values) - 1
    while (first := places[-1]) < last:
        low, high, reached, start = -math.inf, math.inf, first + 1, values[first]
        for step in range(1, last - first + 1):
            rise = values[first + step] - start
            if low <= rise / step <= high:
                reached = first + step
            low, high = max(low, (rise - tolerance) / step), min(high, (rise + tolerance) / step)
            if low > high:
                break
        places.append(reached)
    return np.array(places, np.int64)
