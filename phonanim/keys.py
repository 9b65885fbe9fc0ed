"""Few keys for a curve, within a stated error: cubic spans with shared slopes, or straight ones."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim.animation import Animation


@dataclass(frozen=True)
class Keys:
    """Curves by keys: at `frames` (k,) they have `values` (k, curves) and `slopes` (k, curves) per frame.

    Between keys each curve is the cubic Hermite span, or straight where there are no slopes; `error` is the
    largest distance to the dense curves at their frames.
    """

    frames: NDArray[np.int64]
    values: NDArray[np.float64]
    slopes: NDArray[np.float64] | None
    error: float

    def sample(self, frames: NDArray[np.float64]) -> NDArray[np.float64]:
        """The curves at frames, which may be fractions: (n,) -> (n, curves); the ends hold."""
        if self.slopes is None:
            return np.stack([np.interp(frames, self.frames, curve) for curve in self.values.T], axis=1)
        places = np.clip(frames, self.frames[0], self.frames[-1])
        first = np.clip(
            np.searchsorted(self.frames, places, side="right") - 1, 0, max(len(self.frames) - 2, 0)
        )
        after = np.minimum(first + 1, len(self.frames) - 1)
        ends = (self.values[first], self.slopes[first], self.values[after], self.slopes[after])
        return hermite(
            places - self.frames[first], (self.frames[after] - self.frames[first]).astype(float), *ends
        )


def hermite(
    past: NDArray[np.float64],
    length: NDArray[np.float64],
    value: NDArray[np.float64],
    slope: NDArray[np.float64],
    next_value: NDArray[np.float64],
    next_slope: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Cubic Hermite spans, `past` (n,) after their first key in spans `length` (n,) long: -> (n, curves)."""
    length = np.where(length > 0, length, 1)[:, None]
    t = np.clip(past[:, None] / length, 0, 1)
    u = 1 - t
    ends = value * (1 + 2 * t) * u**2 + next_value * (3 - 2 * t) * t**2
    return np.asarray(ends + length * t * u * (slope * u - next_slope * t))


def reduce_curves(curves: NDArray[np.floating], tolerance: float, straight: bool = False) -> Keys:
    """Keys that all curves share, (frames, curves), such that each is met within `tolerance` at every frame.

    Spans are split at their largest error, then keys that proved needless are taken out again. Slopes are
    those of the dense curves, so the keyed ones bend smoothly; `straight` spans have none.
    """
    dense = np.asarray(curves, np.float64)
    slopes = None if straight else _slopes(dense)
    frames = _pruned(_split(dense, slopes, tolerance), dense, slopes, tolerance)
    keys = Keys(frames, dense[frames], None if slopes is None else slopes[frames], 0.0)
    return replace(keys, error=_largest(keys.sample(np.arange(len(dense), dtype=float)) - dense))


def reduce_channels(animation: Animation, tolerance: float, straight: bool = False) -> dict[str, Keys]:
    """Keys of each channel on its own; one that stands still has one key."""
    return {name: reduce_curve(animation.channel(name), tolerance, straight) for name in animation.channels}


def reduce_curve(curve: NDArray[np.floating], tolerance: float, straight: bool = False) -> Keys:
    """Keys of one curve, (frames,); one key where it stays within `tolerance` of its first value."""
    dense = np.asarray(curve, np.float64)[:, None]
    error = _largest(dense - dense[0])
    if error <= tolerance:
        return Keys(np.zeros(1, np.int64), dense[:1], None if straight else np.zeros((1, 1)), error)
    return reduce_curves(dense, tolerance, straight)


def _largest(differences: NDArray[np.float64]) -> float:
    return float(np.abs(differences).max(initial=0.0))


def describe(keys: dict[str, Keys], animation: Animation) -> str:
    """Keys per second and the largest error of curves that have keys of their own, for people."""
    moving = [item for item in keys.values() if len(item.frames) > 1]
    count = sum(len(item.frames) for item in moving)
    rate = count / max(len(moving), 1) / (len(animation.values) / animation.fps)
    error = max((item.error for item in keys.values()), default=0.0)
    return (
        f"{count} keys in {len(moving)} moving curves, {rate:.1f} per second each, largest error {error:.4f}"
    )


def describe_shared(keys: Keys, animation: Animation) -> str:
    """The same of curves that share their keys."""
    rate = len(keys.frames) / (len(animation.values) / animation.fps)
    count = len(keys.frames)
    return f"{count} keys that all curves share, {rate:.1f} per second, largest error {keys.error:.4f}"


def _slopes(dense: NDArray[np.float64]) -> NDArray[np.float64]:
    """Change per frame of curves, (frames, curves), by central differences."""
    if len(dense) < 2:
        return np.zeros_like(dense)
    return np.asarray(np.gradient(dense, axis=0, edge_order=2 if len(dense) > 2 else 1))


def _errors(
    dense: NDArray[np.float64], slopes: NDArray[np.float64] | None, first: int, last: int
) -> NDArray[np.float64]:
    """The worst curve's error at the frames strictly inside a span, (last - first - 1,)."""
    past = np.arange(1, last - first, dtype=float)
    if slopes is None:
        span = dense[first] + (past / (last - first))[:, None] * (dense[last] - dense[first])
    else:
        length = np.full(len(past), float(last - first))
        span = hermite(past, length, dense[first], slopes[first], dense[last], slopes[last])
    return np.asarray(np.abs(span - dense[first + 1 : last]).max(axis=1))


def _split(dense: NDArray[np.float64], slopes: NDArray[np.float64] | None, tolerance: float) -> list[int]:
    kept, spans = {0, len(dense) - 1}, [(0, len(dense) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        errors = _errors(dense, slopes, first, last)
        middle = first + 1 + int(errors.argmax())
        if errors[middle - first - 1] > tolerance:
            kept.add(middle)
            spans += [(first, middle), (middle, last)]
    return sorted(kept)


def _pruned(
    frames: list[int], dense: NDArray[np.float64], slopes: NDArray[np.float64] | None, tolerance: float
) -> NDArray[np.int64]:
    kept = frames[:1]
    for place in range(1, len(frames) - 1):
        if _errors(dense, slopes, kept[-1], frames[place + 1]).max() > tolerance:
            kept.append(frames[place])
    return np.array([*kept, *frames[1:][-1:]], np.int64)
