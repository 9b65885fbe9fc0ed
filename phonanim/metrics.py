"""How far predicted motion is from captured motion: each measure with its unit and its source."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.face import INNER_LIP_PAIRS, FaceModel
from phonanim.inventory import INVENTORY
from phonanim.phones import PhoneTrack

Shapes = NDArray[np.floating]
Array = NDArray[np.float64]


def vertex_error(predicted: Shapes, captured: Shapes, face: FaceModel) -> Array:
    """Mean distance between corresponding moving landmarks, (frames, landmarks, 3) -> (frames,) mm."""
    apart = (predicted - captured)[:, face.moving]
    return np.asarray(np.linalg.norm(apart, axis=2).mean(axis=1), np.float64)


def correlation(a: NDArray[np.floating], b: NDArray[np.floating]) -> float:
    """Pearson's r of two curves, (frames,) each; NaN where one of them never moves."""
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.sqrt((a**2).sum() * (b**2).sum()))
    return float((a * b).sum()) / scale if scale > 0 else float("nan")


def lip_gap(shapes: Shapes, face: FaceModel) -> Array:
    """Mean vertical distance of the seven inner-lip pairs, (frames, landmarks, 3) -> (frames,) mm."""
    upper, lower = (face.rows(side) for side in zip(*INNER_LIP_PAIRS, strict=True))
    return np.asarray((shapes[:, upper, 1] - shapes[:, lower, 1]).mean(axis=1), np.float64)


def spoken(track: PhoneTrack, times: Array) -> NDArray[np.bool_]:
    """Which instants hold speech and not silence, (times,) -> (times,)."""
    return np.asarray(~INVENTORY.where(kind="silence")[track.sample(times)])


def phone_middles(track: PhoneTrack, phones: tuple[str, ...]) -> Array:
    """Middle of every segment of some phones, -> (segments,) seconds."""
    chosen = np.isin(track.codes, INVENTORY.codes(phones))
    return np.asarray((track.bounds[:-1][chosen] + track.bounds[1:][chosen]) / 2)


def jerk(curve: NDArray[np.floating], fps: float) -> float:
    """Root mean square third derivative of a curve, (frames,) mm -> mm/s^3 (Flash and Hogan 1985)."""
    return float(np.sqrt(np.mean(np.diff(curve, n=3) ** 2)) * fps**3)
