"""The first layer of a network on context features, from the segments that are near instead of all columns.

A box mean is a sum over the gesture parts in the box, of which each has the same row of numbers wherever
it occurs. So the layer's answer to each part in each box is a row of a table, and the answer at an instant
is the sum of a few such rows, each by the share of the box that the part fills.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.core.exact import BITS, exact_layer, unit_below
from phonanim.features.context import (
    EDGES,
    N_BOXES,
    N_TIMING,
    crop_track,
    part_table,
    segment_timing,
)
from phonanim.speech.gestures import split_parts
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]

BLOCK = 48
"""Instants at once: near each other, they have most of their segments in common."""


@dataclass(frozen=True)
class ContextLayer:
    """The answers of a layer: `boxes` (boxes, parts, outputs) and `timing` (12, outputs), whole numbers of
    `unit` (outputs,); `bias` (outputs,) is as it was.
    """

    boxes: NDArray[np.int32]
    timing: Array
    unit: Array
    bias: Array

    def __call__(self, track: PhoneTrack, times: Array) -> Array:
        """What the layer answers at instants, (times,) seconds -> (times, outputs), each by itself."""
        found = np.empty((len(times), len(self.unit)))
        for start in range(0, len(times), BLOCK):
            found[start : start + BLOCK] = self._answer(track, times[start : start + BLOCK])
        return found

    def _answer(self, track: PhoneTrack, times: Array) -> Array:
        local = crop_track(track, times)
        boxes, parts, shares = box_shares(local, times)
        signal = np.concatenate([shares, segment_timing(local, times)], axis=1)
        weights = np.concatenate([self.boxes[boxes, parts], self.timing])
        signal *= 2.0**BITS
        np.rint(signal, out=signal)
        found: Array = signal @ weights
        found *= self.unit * 2.0**-BITS
        found += self.bias
        return found


def context_layer(kind: str, weights: NDArray[np.floating], bias: NDArray[np.floating]) -> ContextLayer:
    """A layer of weights (features, outputs) and a bias (outputs,) on `context_features` of a kind.

    Raises ValueError for another number of features.
    """
    table = part_table(kind)
    outputs = weights.shape[1]
    boxed = weights[:-N_TIMING].reshape(N_BOXES, table.shape[1], outputs)
    columns = boxed.transpose(1, 0, 2).reshape(table.shape[1], -1)
    answers = exact_layer(columns, np.zeros(columns.shape[1]))(table).reshape(len(table), N_BOXES, outputs)
    timing = weights[-N_TIMING:].astype(np.float64)
    # The shares of a box sum to one, and no column of the timing exceeds one.
    most = np.abs(answers).max(axis=0).sum(axis=0) + np.abs(timing).sum(axis=0)
    unit = unit_below(most + np.finfo(np.float64).tiny)
    boxes = np.ascontiguousarray(np.rint(answers / unit).transpose(1, 0, 2), np.int32)  # they have ROOM bits
    return ContextLayer(boxes, np.rint(timing / unit), unit, bias.astype(np.float64))


def box_shares(track: PhoneTrack, times: Array) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Which gesture part occurs in which box around instants (times,), and its share of the box there.

    Box numbers (pairs,), parts (pairs,), shares (times, pairs) from 0 to 1.
    """
    parts = split_parts(track)
    edges = (times[:, None] + EDGES)[:, :, None]
    before = np.clip(edges, parts.bounds[:-1], parts.bounds[1:])
    spent = before[:, 1:] - before[:, :-1]
    boxes, segments = np.nonzero(spent.any(axis=0))
    return boxes, parts.parts[segments], spent[:, boxes, segments] / np.diff(EDGES)[boxes]
