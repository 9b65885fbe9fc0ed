"""Bounded least squares of a few unknowns in many frames, with an L1 prior and a bounded sum."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from phonanim.core.exact import inverse, ordered_product

Array = NDArray[np.float64]

HALVINGS = 24  # rounds of the bisection of a sum


class Pace(NamedTuple):
    """How many rounds are made, how firmly the two halves of one are tied, and how far it oversteps."""

    rounds: int
    firmness: float
    relaxed: float


QUICK = Pace(30, 0.1, 1.6)
"""ARKit's controls are then within some hundredths of the minimum."""
THOROUGH = Pace(80, 0.2, 1.8)
"""Shapes that share a sum, or resemble each other, need more rounds: mouths are then within 0.1 mm."""


def minimize(
    gram: Array,
    pull: Array,
    effort: Array,
    low: Array,
    high: Array,
    shared: NDArray[np.bool_],
    pace: Pace = QUICK,
) -> Array:
    """Min over v of v·gram·v - 2 v·pull + effort·|v| within bounds, (unknowns, frames) -> the same.

    Those that are `shared` (unknowns,) add up to 1 at most. Alternating directions (Boyd et al. 2011, section
    6.4) with a fixed number of rounds, so that no frame depends on the others.
    """
    firmness = pace.firmness * np.diag(gram)[:, None]
    step = inverse(gram + np.diag(firmness[:, 0]))
    shrink = effort[:, None] / 2 / firmness
    values = ordered_product(inverse(gram), pull)
    rows = np.flatnonzero(shared)
    _limit_within(values, low, high, rows, firmness)
    owed = np.zeros_like(values)
    other, free = np.empty_like(values), np.empty_like(values)
    for _ in range(pace.rounds):  # in place, because new arrays would take most of the time
        np.subtract(values, owed, out=other)
        other *= firmness
        other += pull
        ordered_product(step, other, out=free)
        free *= pace.relaxed
        values *= 1 - pace.relaxed
        free += values
        free += owed
        np.minimum(np.maximum(free, -shrink, out=other), shrink, out=other)
        np.subtract(free, other, out=values)
        _limit_within(values, low, high, rows, firmness)
        np.subtract(free, values, out=owed)
    return values


def _limit_within(values: Array, low: Array, high: Array, rows: NDArray[np.int64], firmness: Array) -> None:
    """The nearest values within bounds, in place, (unknowns, frames); those of `rows` in sum at most 1.

    Near is measured by `firmness` (unknowns, 1). Where the sum is too great, all fall by the same over their
    firmness, and bisection finds by how much.
    """
    over = rows[:0]
    if len(rows):
        over = np.flatnonzero(np.clip(values[rows], low[rows], high[rows]).sum(axis=0) > 1)
        part, floor, roof = (of[np.ix_(rows, over)] for of in (values, low, high))
    np.minimum(np.maximum(values, low, out=values), high, out=values)
    if len(over) == 0:
        return
    slope = 1 / firmness[rows]
    least, most = np.zeros(len(over)), ((part - floor) / slope).max(axis=0).clip(0)
    for _ in range(HALVINGS):
        middle = (least + most) / 2
        beyond = np.clip(part - middle * slope, floor, roof).sum(axis=0) > 1
        least, most = np.where(beyond, middle, least), np.where(beyond, most, middle)
    values[np.ix_(rows, over)] = np.clip(part - most * slope, floor, roof)
