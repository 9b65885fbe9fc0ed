"""The measures of a comparison: how each is computed from sums, its unit, and which way is better."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from phonanim.evaluation.statistics import Statistic, pearson, pooled_sd_ratio, ratio

Array = NDArray[np.float64]
CURVE = 6  # sums of a curve beside the captured one, as of phonanim.evaluation.statistics.pearson_sums


@dataclass(frozen=True)
class Measure:
    """`statistic` of the sums, in `unit`; `better` gives the direction of improvement, or the best value."""

    label: str
    unit: str
    statistic: Statistic
    better: Literal["less", "more", "one"]

    @property
    def heading(self) -> str:
        """The label with the unit."""
        return f"{self.label}, {self.unit}" if self.unit else self.label

    def distance(self, values: Array) -> Array:
        """How far values are from the best one, (models,); a gap may be negative for pressed lips."""
        if self.better == "more":
            return -values
        return np.abs(values - 1) if self.better == "one" else np.abs(values)


def root_ratio(totals: Array) -> Array:
    """Root mean square from (sum of squares, count), (..., 2) -> (...,)."""
    return np.asarray(np.sqrt(ratio(totals)))


def curve_r(totals: Array) -> Array:
    """R of each of several curves, (..., curves * 6) -> (..., curves); NaN where either is still."""
    return pearson(_curves(totals))


def curve_sd_ratio(totals: Array) -> Array:
    """Deviation of each of several curves over the captured one; NaN where that is still."""
    return pooled_sd_ratio(_curves(totals))


def mean_r(totals: Array) -> Array:
    """Mean r of several curves, (..., curves * 6) -> (...,).

    A curve that a model keeps still counts as 0, one that was captured still is left out; NaN where a model
    moves none.
    """
    r, ratio_of = curve_r(totals), curve_sd_ratio(totals)
    filled = np.where(np.isfinite(ratio_of), np.nan_to_num(r), np.nan)
    return np.where(np.isfinite(r).any(axis=-1), _mean(filled), np.nan)


def mean_sd_ratio(totals: Array) -> Array:
    """Mean ratio of deviations of several curves, (..., curves * 6) -> (...,)."""
    return _mean(curve_sd_ratio(totals))


def _curves(totals: Array) -> Array:
    """(..., curves * 6) -> (..., curves, 6)."""
    return totals.reshape(*totals.shape[:-1], -1, CURVE)


def _mean(values: Array) -> Array:
    """Mean over the last axis of what is finite; NaN where nothing is."""
    known = np.isfinite(values)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(known, values, 0).sum(axis=-1) / known.sum(axis=-1))


LANDMARKS = {
    "parameter_mse": Measure("parameter MSE", "mm²", ratio, "less"),
    "shape_mse": Measure("shape MSE", "mm²", ratio, "less"),
    "vertex_error": Measure("vertex error", "mm", ratio, "less"),
    "lip_error": Measure("LVE", "mm", ratio, "less"),
    "speed_error": Measure("velocity error", "mm/s", ratio, "less"),
    "aperture_r": Measure("aperture r", "", pearson, "more"),
    "width_r": Measure("width r", "", pearson, "more"),
    "pbm_gap": Measure("p b m gap", "mm", ratio, "less"),
    # Of rendered mouths: comparison/mouths.py.
    "joint_mse": Measure("joint parameter MSE", "", ratio, "less"),
    "pixel_mse": Measure("pixel MSE", "grey²", ratio, "less"),
    "inner_pixel_mse": Measure("inside the mouth", "grey²", ratio, "less"),
    "outer_pixel_mse": Measure("around it", "grey²", ratio, "less"),
}

OWN_MOTION = {
    "curves_r": Measure("r", "", mean_r, "more"),
    "curves_sd_ratio": Measure("sd ratio", "", mean_sd_ratio, "one"),
    "control_l1": Measure("L1, sum over controls", "", ratio, "less"),
    "control_l2": Measure("MCE (L2)", "", ratio, "less"),
    "mouth_l2": Measure("LCE", "", ratio, "less"),
    "channel_error": Measure("error", "mm", root_ratio, "less"),
    "mesh_error": Measure("MVE", "", ratio, "less"),
    "mesh_lip_error": Measure("LVE", "", ratio, "less"),
}
"""Of controls, sensors and vertices: comparison/motion_scores.py."""

MEASURES = LANDMARKS | OWN_MOTION
