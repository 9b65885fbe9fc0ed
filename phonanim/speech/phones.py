"""Phones in the model's own inventory, as contiguous segments of continuous time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class PhoneTrack:
    """The phones of a line: segment i is phone `codes[i]` from `bounds[i]` to `bounds[i + 1]`.

    `codes` is (segments,) uint8, indices into the inventory (lexicon/phones.csv). `bounds` is
    (segments + 1,) float64 seconds, strictly rising from 0 to the duration. `labels` are the labels of the
    alignment that each segment came from ("" where a gap was filled with silence). `rounding` is how far the
    language rounds its lips, against English.
    """

    codes: NDArray[np.uint8]
    bounds: NDArray[np.float64]
    labels: tuple[str, ...]
    rounding: float = 1.0

    @property
    def duration(self) -> float:
        """Seconds from the start to the end of the last segment."""
        return float(self.bounds[-1])

    def segment_at(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Index of the segment that contains each time, (times,) seconds -> (times,); clamped at the ends."""
        found = np.searchsorted(self.bounds, times, side="right") - 1
        return np.clip(found, 0, len(self.codes) - 1)

    def sample(self, times: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Phone code at each time, (times,) seconds -> (times,) uint8."""
        return self.codes[self.segment_at(times)]

    def distance_to(self, chosen: NDArray[np.bool_], times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Seconds from each time to the nearest of the chosen segments, (segments,) -> (times,).

        0 within them, inf when none is chosen.
        """
        begins = np.append(self.bounds[:-1][chosen], np.inf)
        ends = np.append(-np.inf, self.bounds[1:][chosen])
        later = np.searchsorted(begins, times, side="right")
        nearest: NDArray[np.float64] = np.minimum(times - ends[later], begins[later] - times)
        return np.maximum(nearest, 0.0)


def silent_track(duration: float) -> PhoneTrack:
    """A track of silence, `duration` seconds long (code 0 is silence)."""
    return PhoneTrack(np.zeros(1, np.uint8), np.array([0.0, duration]), ("",))


def pair_rows(firsts: NDArray[np.int64], lasts: NDArray[np.int64]) -> tuple[NDArray[np.int64], ...]:
    """Every pair of an item and a row from its first up to its last, (items,) each -> (pairs,) items, rows.

    Pairs are in the order of the items, so `np.bincount` sums in that order.
    """
    counts = np.maximum(lasts - firsts, 0)
    items = np.repeat(np.arange(len(counts)), counts)
    before = np.cumsum(counts) - counts
    return items, np.arange(len(items)) + (firsts - before)[items]
