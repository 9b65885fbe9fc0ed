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

FIRST_LOOK = 4  # frames; doubled until a key is found
PART = 1024  # frames between keys that are always set in longer takes, so that parts are reduced side by side
PATIENCE = 32  # frames that are tried after the last one that can be a key


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
    if len(dense) > PART:
        return _keys_at(_side_by_side(dense, len(dense), tolerance), dense)
    places, moving = [0], dense[:, (dense != dense[0]).any(axis=0)]
    while places[-1] < len(dense) - 1:
        places.append(_farthest(moving, places[-1], tolerance))
    return _keys_at(np.array(places, np.int64), dense)


def reduce_channels(animation: Animation, tolerance: float) -> dict[str, Keys]:
    """Keys of each channel separately; a constant channel has one key."""
    if len(animation.values) <= PART:
        return {name: reduce_curve(animation.channel(name), tolerance) for name in animation.channels}
    values = np.asarray(animation.values, np.float64)
    errors, count = np.abs(values - values[0]).max(axis=0), len(values)
    moving = np.flatnonzero(errors > tolerance)
    places = _side_by_side(values[:, moving].T.reshape(-1, 1), count, tolerance)
    frames: dict[int, NDArray[np.int64]] = {
        column: places[slice(*np.searchsorted(places, [row * count, (row + 1) * count]))] - row * count
        for row, column in enumerate(moving.tolist())
    }
    still = np.zeros(1, np.int64)
    return {
        name: _keys_at(frames.get(column, still), values[:, column : column + 1])
        for column, name in enumerate(animation.channels)
    }


def reduce_curve(curve: NDArray[np.floating], tolerance: float) -> Keys:
    """Keys of one curve, (frames,); one key where it stays within `tolerance` of its first value."""
    dense = np.asarray(curve, np.float64)[:, None]
    error = _largest(dense - dense[0])
    if error <= tolerance:
        return Keys(np.zeros(1, np.int64), dense[:1], error)
    long = len(dense) > PART
    return _keys_at(
        _side_by_side(dense, len(dense), tolerance) if long else _single(dense[:, 0], tolerance), dense
    )


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


def _keys_at(frames: NDArray[np.int64], dense: NDArray[np.float64]) -> Keys:
    """The keys of curves (n, curves) at frames (k,), with their error."""
    keys = Keys(frames, dense[frames], 0.0)
    return Keys(frames, keys.values, _largest(keys.sample(np.arange(len(dense), dtype=float)) - dense))


def _side_by_side(dense: NDArray[np.float64], count: int, tolerance: float) -> NDArray[np.int64]:
    """The rows of keys of curves (n, curves), whose rows are one or several takes of `count` frames.

    Parts of PART frames are searched as `_farthest` does it, a frame of each at a time.
    """
    starts = (np.arange(0, len(dense), count)[:, None] + np.arange(0, max(count - 1, 1), PART)).ravel()
    ends = np.minimum(starts + PART, (starts // count + 1) * count - 1)
    found = [starts, ends]
    search = _Search(dense, tolerance, starts, ends)
    while len(search.first):
        found.append(search.step())
    return np.unique(np.concatenate(found))


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
        (closed,) = (low > high).any(axis=1).nonzero()
        if len(closed) or last == len(dense) - 1:
            break
        ahead *= 2
    slopes = rise[1:] / steps[1:]
    fits = ((slopes >= low[:-1]) & (slopes <= high[:-1])).all(axis=1)
    (reached,) = (fits[: closed[0]] if len(closed) else fits).nonzero()
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
            lowest, highest = (rise - tolerance) / step, (rise + tolerance) / step
            if lowest > low:  # in place of max and min, which would take most of the time
                low = lowest
            if highest < high:
                high = highest
            if low > high or first + step - reached >= PATIENCE:
                break
        places.append(reached)
    return np.array(places, np.int64)


class _Search:
    """The search for the next key of several parts of curves; `first` (parts,) are their last keys."""

    def __init__(
        self,
        dense: NDArray[np.float64],
        tolerance: float,
        starts: NDArray[np.int64],
        ends: NDArray[np.int64],
    ) -> None:
        self.dense, self.tolerance = dense, tolerance
        self.first, self.ends = starts[starts < ends], ends[starts < ends]
        self.reached, self.place = self.first + 1, self.first + 1
        self.low = np.full((len(self.first), dense.shape[1]), -np.inf)
        self.high = np.full_like(self.low, np.inf)

    def step(self) -> NDArray[np.int64]:
        """Try one frame of every part, and return the keys that are found."""
        steps = (self.place - self.first)[:, None]
        rise = self.dense[self.place] - self.dense[self.first]
        slope = rise / steps
        fits = ((slope >= self.low) & (slope <= self.high)).all(axis=1)
        np.copyto(self.reached, self.place, where=fits)
        np.maximum(self.low, (rise - self.tolerance) / steps, out=self.low)
        np.minimum(self.high, (rise + self.tolerance) / steps, out=self.high)
        over = (self.low > self.high).any(axis=1) | (self.place == self.ends)
        over |= self.place - self.reached >= PATIENCE
        self.place += 1
        if not over.any():
            return self.first[:0]
        keys = self.reached[over]
        self.first[over] = keys
        self.reached[over] = self.place[over] = keys + 1
        self.low[over], self.high[over] = -np.inf, np.inf
        left = self.first < self.ends
        if not left.all():
            for name in ("first", "ends", "reached", "place", "low", "high"):
                setattr(self, name, getattr(self, name)[left])
        return keys
