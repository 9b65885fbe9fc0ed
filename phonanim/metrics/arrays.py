"""Errors of arrays whose first axis is frames: parameters, shapes, pixels, controls, sensors.

Each measure is per frame. Its mean over frames is the figure that papers print; the values per frame are used
for tables by phone and for confidence intervals.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import EvaluationError

Array = NDArray[np.float64]
Frames = NDArray[np.floating] | NDArray[np.integer]


def squared_error(predicted: Frames, captured: Frames) -> Array:
    """Mean squared difference per frame, (frames, ...) twice -> (frames,), in the unit squared.

    e_t = 1/D sum_d (x_td - y_td)². Its mean is the MSE of Taylor 2017, section 8.2 and figure 10, in
    parameter (mm²), shape (mm²) or pixel space (grey levels², 0 to 255), and L_r of Medina 2023, eq. 4.9.
    Raises EvaluationError when the shapes differ.
    """
    return _per_frame(difference(predicted, captured) ** 2)


def absolute_error(predicted: Frames, captured: Frames) -> Array:
    """Mean absolute difference per frame, (frames, ...) twice -> (frames,), in the same unit.

    e_t = 1/D sum_d |x_td - y_td|. Raises EvaluationError when the shapes differ.
    """
    return _per_frame(np.abs(difference(predicted, captured)))


def summed_absolute_error(predicted: Frames, captured: Frames) -> Array:
    """Sum of absolute differences per frame (L1), (frames, ...) twice -> (frames,), in the same unit.

    e_t = sum_d |x_td - y_td|. The L1 errors of Medina 2023, tables 4.4 to 4.7, about 4 for 67 parameters
    within 0 and 1 beside L2 errors below 1, can only be this sum. It grows with the number of values. Raises
    EvaluationError when the shapes differ.
    """
    apart = np.abs(difference(predicted, captured))
    return np.asarray(apart.reshape(len(apart), -1).sum(axis=1))


def euclidean_error(predicted: Frames, captured: Frames) -> Array:
    """Length of the difference of whole frames (L2), (frames, ...) twice -> (frames,), in the same unit.

    e_t = sqrt(sum_d (x_td - y_td)²) (Medina 2023, section 4.7). Over controls, its mean over frames is MCE,
    and over those of the mouth LCE, as the released code of FaceDiffuser computes them. It grows with the
    number of values, so use it to compare methods on one rig, not to compare rigs. Raises EvaluationError
    when the shapes differ.
    """
    flat = difference(predicted, captured).reshape(len(predicted), -1)
    return np.asarray(np.linalg.norm(flat, axis=1))


def difference(predicted: Frames, captured: Frames) -> Array:
    """Predicted minus captured, same shape. Raises EvaluationError when the shapes differ or are empty."""
    if np.shape(predicted) != np.shape(captured):
        raise EvaluationError(
            f"the predictions have shape {np.shape(predicted)}, the reference {np.shape(captured)}; "
            "they must be equal: cut or resample one of them"
        )
    if np.size(predicted) == 0:
        raise EvaluationError(f"nothing to compare: both have shape {np.shape(predicted)}")
    return np.asarray(predicted, np.float64) - np.asarray(captured, np.float64)


def _per_frame(values: Array) -> Array:
    return np.asarray(values.reshape(len(values), -1).mean(axis=1))
