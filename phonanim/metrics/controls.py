"""Measures of a rig's controls beside their errors: how lively they are, and how far takes differ."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import EvaluationError
from phonanim.metrics.arrays import Array, Frames

Columns = NDArray[np.integer] | NDArray[np.bool_] | slice
EVERY = slice(None)


def control_dynamics_deviation(
    predicted: Frames, captured: Frames, upper: Columns, motion: Literal["step", "energy"] = "step"
) -> float:
    """C-FDD: how much more the captured upper controls move than the predicted; 0 is best.

    "step": 1/K sum_k (sd_t |w_tk - w_(t-1)k| - sd_t |v_tk - v_(t-1)k|), equation 6 of FaceDiffuser 2023 with
    controls for vertices. "energy": sd_t sum_k w_tk² - sd_t sum_k v_tk², as its released code computes it.
    Both are (frames, controls); their numbers of frames may differ. Raises EvaluationError for another
    `motion`.
    """
    return _activity(captured, upper, motion) - _activity(predicted, upper, motion)


def control_diversity(takes: Frames, columns: Columns = EVERY) -> float:
    """Mean absolute difference of any two takes of one line, (takes, frames, controls) -> controls' unit.

    Equation 7 of FaceDiffuser 2023 with controls for vertices. Raises EvaluationError for fewer than two.
    """
    if len(takes) < 2:
        raise EvaluationError(f"diversity needs at least two takes of a line, not {len(takes)}")
    chosen = np.asarray(takes, np.float64)[..., columns]
    first, second = np.triu_indices(len(chosen), k=1)
    return float(np.mean([np.abs(chosen[i] - chosen[j]).mean() for i, j in zip(first, second, strict=True)]))


def _activity(curves: Frames, columns: Columns, motion: str) -> float:
    """Standard deviation over time of the controls' motion: a mean over controls, or of their energy."""
    chosen: Array = np.asarray(curves, np.float64)[:, columns]
    if motion == "step":
        return float(np.abs(np.diff(chosen, axis=0)).std(axis=0).mean())
    if motion == "energy":
        return float((chosen**2).sum(axis=1).std())
    raise EvaluationError(f"there is no motion {motion!r}; use step or energy")
