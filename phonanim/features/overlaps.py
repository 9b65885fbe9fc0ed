"""The first layer of a network on context features, from the segments that are near instead of all columns.

A box mean is a sum over the gesture parts in the box, of which each has the same row of numbers wherever
it occurs. So the layer's answer to each part in each box is a row of a table, and the answer at an instant
is the sum of a few such rows, each by the share of the box that the part fills.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.core.exact import exact_layer, rounded, unit_below
from phonanim.features.context import (
    EDGES,
    N_BOXES,
    N_TIMING,
    crop_track,
    part_table,
    segment_timing,
)
from phonanim.speech.gestures import split_parts
from phonanim.speech.phones import PhoneTrack, pair_rows

Array = NDArray[np.float64]

BLOCK = 12
"""Instants at once: near each other, they have most of their segments in common."""


@dataclass(frozen=True)
class ContextLayer:
    """The answers of a layer to parts in boxes, `boxes` (boxes, parts, outputs), and to the timing, `timing`
    (12, outputs): whole multiples of a power of two in each column. `bias` is (outputs,).
    """

    boxes: Array
    timing: Array
    bias: Array

    def __call__(self, track: PhoneTrack, times: Array) -> Array:
        """What the layer answers at instants, (times,) seconds -> (times, outputs), each by itself."""
        found = np.empty((len(times), len(self.bias)))
        if len(times) == 0:
            return found
        local, near = crop_track(track, times), in_blocks(times)
        counts, boxes, parts, shares = box_shares(local, near)
        rows, table = boxes * self.boxes.shape[1] + parts, self.boxes.reshape(-1, self.boxes.shape[2])
        shares, weights = rounded(shares, 0), np.empty((counts.max(), table.shape[1]))
        for number, (end, count) in enumerate(zip(np.cumsum(counts).tolist(), counts.tolist(), strict=True)):
            block = found[number * near.shape[1] : (number + 1) * near.shape[1]]
            table.take(rows[end - count : end], axis=0, out=weights[:count], mode="clip")
            np.matmul(shares[end - count : end, : len(block)].T, weights[:count], out=block)
        found += rounded(segment_timing(local, times), 0) @ self.timing
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
    boxes = np.ascontiguousarray((np.rint(answers / unit) * unit).transpose(1, 0, 2))
    return ContextLayer(boxes, np.rint(timing / unit) * unit, bias.astype(np.float64))


def in_blocks(times: Array) -> Array:
    """Instants in blocks of a few, (times,) -> (blocks, at once); the last one repeats to fill a block."""
    size = min(BLOCK, len(times))
    count = -(-len(times) // size)
    return np.append(times, np.full(count * size - len(times), times[-1])).reshape(count, size)


def box_shares(
    track: PhoneTrack, times: Array
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], Array]:
    """Which gesture part occurs in which box around the instants of a block, (blocks, at once) seconds.

    The pairs of box and part of each block (blocks,), one block after the other: their boxes (pairs,), parts
    (pairs,), and shares of the box (pairs, at once) from 0 to 1 at each instant of the block.
    """
    split = split_parts(track)
    ends = np.stack([times.min(axis=1), times.max(axis=1)])[:, :, None] + EDGES
    inner = split.bounds[1:-1]
    first = np.searchsorted(inner, ends[0, :, :-1], side="right")
    last = np.searchsorted(inner, ends[1, :, 1:], side="left") + 1
    places, segments = pair_rows(first.ravel(), last.ravel())
    blocks, boxes = np.divmod(places, N_BOXES)
    start, stop = (bound[segments, None] for bound in (split.bounds[:-1], split.bounds[1:]))
    before = times.take(blocks, axis=0)
    spent = before + EDGES[1:][boxes, None]
    np.minimum(np.maximum(spent, start, out=spent), stop, out=spent)
    before += EDGES[boxes, None]
    np.minimum(np.maximum(before, start, out=before), stop, out=before)
    spent -= before
    spent /= np.diff(EDGES)[boxes, None]
    return (last - first).sum(axis=1), boxes, split.parts[segments], spent
