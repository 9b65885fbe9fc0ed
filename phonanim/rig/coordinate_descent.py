"""Bounded least squares with an L1 prior and ties between neighbours, for many frames at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SETTLED = 1e-4  # stop when no value changes more than this
PIVOT = 1e-9  # keeps an unknown without effect at its value


@dataclass(frozen=True)
class Problem:
    """min over v of Σ_t ½ v_t·gram·v_t − pull_t·v_t + ½ sparse |v_t| + ½ smooth |v_t − v_t−1|², bounded.

    `gram` (n, n), `pull` (frames, n), `minimum` and `maximum` (n,) or (frames, n), `sparse` (n,); `ends` are
    the frames at which a chain of tied frames ends (exclusive).
    """

    gram: Array
    pull: Array
    minimum: Array
    maximum: Array
    sparse: Array
    smooth: float
    ends: NDArray[np.int64]


def descend(problem: Problem, start: Array, sweeps: int = 200) -> Array:
    """Coordinate descent, (frames, n) -> (frames, n): even frames with the odd ones held, then odd ones.

    Each step sets one unknown of every second frame to its optimum in closed form, so the energy never
    rises and the bounds always hold.
    """
    frames = np.arange(len(start))
    after = ~np.isin(frames + 1, problem.ends)
    before = np.roll(after, 1)
    low, high = (np.broadcast_to(limit, start.shape) for limit in (problem.minimum, problem.maximum))
    values = np.clip(start, low, high)
    for _ in range(sweeps):
        moved = 0.0
        for half in (frames[::2], frames[1::2]):
            tied = (
                before[half, None] * values[half - 1] + after[half, None] * values[(half + 1) % len(frames)]
            )
            ties = before[half].astype(float) + after[half]
            pull = problem.pull[half] + problem.smooth * tied
            new = _sweep(problem, values[half], pull, problem.smooth * ties, low[half], high[half])
            moved = max(moved, float(np.abs(new - values[half]).max(initial=0.0)))
            values[half] = new
        if moved < SETTLED:
            break
    return values


def _sweep(problem: Problem, values: Array, pull: Array, ties: Array, low: Array, high: Array) -> Array:
    """Set each unknown to its optimum in turn, (frames, n) -> (frames, n)."""
    values, gram = values.copy(), problem.gram
    for j in range(len(gram)):
        slope = pull[:, j] - values @ gram[:, j] + gram[j, j] * values[:, j]
        slope = np.sign(slope) * np.maximum(np.abs(slope) - problem.sparse[j] / 2, 0.0)
        values[:, j] = np.clip(slope / (gram[j, j] + ties + PIVOT), low[:, j], high[:, j])
    return values
