"""Measures of two motions at the same instants: controls, vertices, lips.

Each name ends in its unit: `_mm`, `_mm2`, `_ms`, `_db`; `_r` is a correlation, `_ratio` a ratio and
`_slope` a slope; controls have the rig's units.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.errors import EvaluationError
from phonanim.evaluation.surfaces import Rows, Surface
from phonanim.metrics import (
    absolute_error,
    closure_error,
    control_dynamics_deviation,
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
    summed_absolute_error,
    temporal_mean_vertex_error,
    temporal_misalignment,
)
from phonanim.metrics.lips import BILABIALS, LABIODENTALS
from phonanim.rig.morphs import plain_name
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
MOUTH_CONTROLS = ("jaw", "mouth", "tongue")
UPPER_CONTROLS = ("brow", "eye")
OTHER_FACE = (
    2.0  # mm of the upper face; of ICT-FaceKit's faces 95 pairs in 100 differ by more, raised brows less
)
CONTACTS = {"pbm": BILABIALS, "fv": LABIODENTALS}


def control_regions(channels: tuple[str, ...], masks: Mapping[str, Rows]) -> dict[str, Rows]:
    """Columns of controls by region: `lips` and `upper` by their names, and the user's regions.

    Raises EvaluationError when a region has a control beyond the last.
    """
    found: dict[str, Rows] = {}
    for region, heads in (("lips", MOUTH_CONTROLS), ("upper", UPPER_CONTROLS)):
        named = [row for row, name in enumerate(channels) if plain_name(name).startswith(heads)]
        if named:
            found[region] = np.array(named, np.int64)
    for region, rows in masks.items():
        if rows.max() >= len(channels):
            raise EvaluationError(
                f"mask {region} has control {rows.max()}, but the last control is {len(channels) - 1}; "
                "these are controls of no known mesh, so a mask numbers controls, from 0"
            )
    return found | dict(masks)


def control_measures(
    predicted: Animation, captured: Animation, regions: Mapping[str, Rows]
) -> dict[str, float]:
    """Errors of curves over all controls and over those of a region (`lips`, `upper`), in their units."""
    ours, theirs = predicted.values.astype(np.float64), captured.values.astype(np.float64)
    liveliest = int(theirs.var(axis=0).argmax())
    measures = {
        "control_mse": squared_error(ours, theirs).mean(),
        "control_mae": absolute_error(ours, theirs).mean(),
        "control_l1_medina": summed_absolute_error(ours, theirs).mean(),
        "control_l2": euclidean_error(ours, theirs).mean(),
        "control_speed_error_per_s": derivative_error(ours, theirs, captured.fps),
        "control_acceleration_error_per_s2": derivative_error(ours, theirs, captured.fps, order=2),
        "control_lag_ms": 1000 * lag(ours[:, liveliest], theirs[:, liveliest], captured.fps)[0],
    }
    for region, columns in regions.items():
        if region == "lips":
            measures["mouth_control_mse"] = squared_error(ours[:, columns], theirs[:, columns]).mean()
            measures["lce"] = euclidean_error(ours[:, columns], theirs[:, columns]).mean()
        elif region == "upper":
            measures["c_fdd"] = control_dynamics_deviation(ours, theirs, columns)
            measures["c_fdd_energy"] = control_dynamics_deviation(ours, theirs, columns, "energy")
        else:
            measures[f"control_l2_{region}"] = euclidean_error(ours[:, columns], theirs[:, columns]).mean()
    return {name: float(value) for name, value in measures.items()}


def find_rest(captured: Surface) -> tuple[Array | None, str]:
    """The face at rest that FDD is measured from, (vertices, 3) mm, or None and why there is none.

    A template whose upper face is more than OTHER_FACE from the captured mean is of another subject.
    """
    if "upper" not in captured.masks:
        return None, ""
    mend = "give each subject's own face at rest: --template MESH, or --template FOLDER of one per subject"
    if captured.rest is None:
        return None, f"fdd_mm and fdd_squared_mm2 are left out, as the face at rest is unknown; {mend}"
    upper = captured.masks["upper"]
    away = captured.points[:, upper].mean(axis=0) - captured.rest[upper]
    apart = float(np.linalg.norm(away, axis=1).mean())
    if apart > OTHER_FACE:
        return None, (
            f"fdd_mm and fdd_squared_mm2 are left out: the template's upper face is {apart:.1f} mm from the "
            f"reference's, so it is another subject's; {mend}"
        )
    return captured.rest, ""


def vertex_measures(ours: Surface, theirs: Surface, fps: float) -> dict[str, float]:
    """Errors of vertices, over the mesh and by region; FDD from rest only where `find_rest` knows it."""
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
        rest, _ = find_rest(theirs)
        if rest is not None:
            measures["fdd_mm"] = dynamics_deviation(*points, rest, upper)
            measures["fdd_squared_mm2"] = dynamics_deviation(*points, rest, upper, "squared offset")
        measures["fdd_step_mm"] = dynamics_deviation(*points, theirs.points[0], upper, "step")
    regions = temporal_mean_vertex_error(*points, ours.masks)
    measures |= {f"tmve_{name}_mm": value for name, value in regions.items()}
    squares = temporal_mean_vertex_error(*points, ours.masks, squared=True)
    measures |= {f"tmve_{name}_squared_mm2": value for name, value in squares.items()}
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
        "aperture_mtm_ms": 1000 * temporal_misalignment(mine, wanted, fps),
        "aperture_speed_error_mm_s": derivative_error(mine, wanted, fps),
        "aperture_spectral_distance_db": log_spectral_distance(mine, wanted, fps),
        "aperture_jerk_ratio": _share(jerk(mine, fps), jerk(wanted, fps)),
    }
    speech = np.ones(len(times), bool) if track is None else speech_mask(track, times)
    for side, curve in (("", mine), ("captured_", wanted)):
        measures[f"{side}lip_intensity_mm_s"] = mean_speed(curve, speech, fps)
    if track is None:
        return measures
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


def mean_speed(curve: Array, frames: NDArray[np.bool_], fps: float) -> float:
    """Mean absolute change of a curve per second where both frames are chosen, (frames,) mm -> mm/s."""
    both = frames[1:] & frames[:-1]
    return float(np.abs(np.diff(curve))[both].mean() * fps) if both.any() else float("nan")


def _share(part: float, whole: float) -> float:
    return part / whole if whole > 0 else float("nan")
