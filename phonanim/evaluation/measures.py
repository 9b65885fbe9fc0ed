"""Measures of two motions at the same instants: controls, vertices, lips.

Each name ends in its unit: `_mm`, `_mm2`, `_ms`, `_db`; `_r` is a correlation, `_ratio` a ratio and
`_slope` a slope; controls have the rig's units.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.evaluation.surfaces import Surface
from phonanim.metrics import (
    absolute_error,
    closure_error,
    correlation,
    derivative_error,
    dynamics_deviation,
    euclidean_error,
    jerk,
    lag,
    least_gaps,
    lip_vertex_error,
    log_spectral_distance,
    mean_vertex_error,
    regression_slope,
    sd_ratio,
    speech_mask,
    squared_error,
    temporal_mean_vertex_error,
)
from phonanim.metrics.lips import BILABIALS, LABIODENTALS
from phonanim.rig.morphs import plain_name
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
MOUTH_CONTROLS = ("jaw", "mouth", "tongue")
CONTACTS = {"pbm": BILABIALS, "fv": LABIODENTALS}


def control_measures(predicted: Animation, captured: Animation) -> dict[str, float]:
    """Errors of curves over all controls and over those of the mouth, in the controls' units."""
    ours, theirs = predicted.values.astype(np.float64), captured.values.astype(np.float64)
    mouth = [i for i, name in enumerate(captured.channels) if plain_name(name).startswith(MOUTH_CONTROLS)]
    liveliest = int(theirs.var(axis=0).argmax())
    measures = {
        "control_mse": squared_error(ours, theirs).mean(),
        "control_l1": absolute_error(ours, theirs).mean(),
        "control_l2": euclidean_error(ours, theirs).mean(),
        "control_speed_error_per_s": derivative_error(ours, theirs, captured.fps),
        "control_acceleration_error_per_s2": derivative_error(ours, theirs, captured.fps, order=2),
        "control_lag_ms": 1000 * lag(ours[:, liveliest], theirs[:, liveliest], captured.fps)[0],
    }
    if mouth:
        measures["mouth_control_mse"] = squared_error(ours[:, mouth], theirs[:, mouth]).mean()
    return {name: float(value) for name, value in measures.items()}


def vertex_measures(ours: Surface, theirs: Surface, fps: float) -> dict[str, float]:
    """Errors of vertices, over the mesh and by region; the mean captured face is the default rest pose."""
    rest = theirs.rest if theirs.rest is not None else theirs.points.mean(axis=0)
    points = ours.points, theirs.points
    measures = {
        "vertex_mse_mm2": squared_error(*points).mean(),
        "mve_mm": mean_vertex_error(*points).mean(),
        "vertex_speed_error_mm_s": derivative_error(*points, fps),
        "vertex_acceleration_error_mm_s2": derivative_error(*points, fps, order=2),
    }
    if "lips" in ours.masks:
        lips = ours.masks["lips"]
        measures["lve_mm"] = lip_vertex_error(*points, lips).mean()
        measures["lve_squared_mm2"] = lip_vertex_error(*points, lips, squared=True).mean()
    if "upper" in ours.masks:
        upper = ours.masks["upper"]
        measures["fdd_mm"] = dynamics_deviation(*points, rest, upper)
        measures["fdd_squared_mm2"] = dynamics_deviation(*points, rest, upper, "squared offset")
        measures["fdd_step_mm"] = dynamics_deviation(*points, rest, upper, "step")
    regions = temporal_mean_vertex_error(*points, ours.masks)
    measures |= {f"tmve_{name}_mm": value for name, value in regions.items()}
    return {name: float(value) for name, value in measures.items()}


def lip_measures(
    ours: Mapping[str, Array], theirs: Mapping[str, Array], times: Array, fps: float, track: PhoneTrack | None
) -> dict[str, float]:
    """Agreement of lip curves; with a track, also over speech only and at closures."""
    measures: dict[str, float] = {}
    for name in theirs:
        pair = ours[name], theirs[name]
        measures |= {
            f"{name}_r": correlation(*pair),
            f"{name}_sd_ratio": sd_ratio(*pair),
            f"{name}_slope": regression_slope(*pair),
        }
    mine, wanted = ours["aperture"], theirs["aperture"]
    delay, best = lag(mine, wanted, fps)
    measures |= {
        "aperture_lag_ms": 1000 * delay,
        "aperture_r_without_lag": best,
        "aperture_speed_error_mm_s": derivative_error(mine, wanted, fps),
        "aperture_spectral_distance_db": log_spectral_distance(mine, wanted, fps),
        "aperture_jerk_ratio": _share(jerk(mine, fps), jerk(wanted, fps)),
    }
    if track is None:
        return measures
    speech = speech_mask(track, times)
    if speech.sum() > 1:
        for name in theirs:
            pair = ours[name][speech], theirs[name][speech]
            measures |= {
                f"{name}_r_speech": correlation(*pair),
                f"{name}_sd_ratio_speech": sd_ratio(*pair),
                f"{name}_slope_speech": regression_slope(*pair),
            }
    for name, phones in CONTACTS.items():
        gaps = least_gaps(mine, times, track, phones)
        if len(gaps):
            measures[f"{name}_least_gap_mm"] = float(gaps.mean())
            measures[f"{name}_closure_error_mm"] = float(
                closure_error(mine, wanted, times, track, phones).mean()
            )
    return measures


def _share(part: float, whole: float) -> float:
    return part / whole if whole > 0 else float("nan")
