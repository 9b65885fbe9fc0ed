"""Ranges and moments of the frames of many clips, in one pass, for targets that scale them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import CorpusError
from phonanim.targets import Array, Clip, Floats, TargetSettings

STILL = 1e-6  # of the largest range: a number that changes less does not move


@dataclass(frozen=True)
class Moments:
    """Of each number of a frame, (numbers,): least, greatest, mean and standard deviation."""

    least: Array
    most: Array
    mean: Array
    deviation: Array

    @property
    def moving(self) -> NDArray[np.bool_]:
        """The numbers that change, (numbers,)."""
        ranges = self.most - self.least
        return np.asarray(ranges > STILL * ranges.max())

    def scaling(self, settings: TargetSettings) -> tuple[Floats, Floats]:
        """What is taken off each number, and what the rest is divided by, (numbers,); still ones by 1."""
        low, span = {
            "minmax": (self.least, self.most - self.least),
            "zscore": (self.mean, self.deviation),
            "none": (np.zeros_like(self.mean), np.ones_like(self.mean)),
        }[settings.scale]
        low, span = np.where(self.moving, low, self.mean), np.where(self.moving, span, 1.0)
        return as_single(low), as_single(span)


def as_single(values: Array) -> Floats:
    """Numbers in single precision."""
    return values.astype(np.float32)


def moments_of(clips: Iterable[Clip], data: str) -> Moments:
    """Moments of the frames of clips, (frames, ...). Raises CorpusError when nothing moves in them."""
    count, total, square = 0, np.zeros(1), np.zeros(1)
    low, high = np.full(1, np.inf), np.full(1, -np.inf)
    for frames, _ in clips:
        flat = np.asarray(frames, np.float64).reshape(len(frames), -1)
        count += len(flat)
        low, high = np.minimum(low, flat.min(axis=0)), np.maximum(high, flat.max(axis=0))
        total, square = total + flat.sum(axis=0), square + (flat**2).sum(axis=0)
    if count == 0 or not (high > low).any():
        raise CorpusError(f"{data}: nothing moves in its training clips; check the split and the motion")
    mean = total / count
    return Moments(low, high, mean, np.sqrt(np.maximum(square / count - mean**2, 0)))
