"""Single curves over time: correlation, delay, speed, spectrum and roughness.

A curve is a lip opening in mm, a control or the coordinate of a sensor; several curves are columns.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import EvaluationError
from phonanim.metrics.arrays import Array, difference

Curve = NDArray[np.floating]
REACH = 0.25  # seconds on both sides in which a lag is searched
SECTION = 1.0  # seconds of a section of Welch's periodogram: bins 1 Hz apart
FLOOR = 1e-6  # share of a spectrum's largest bin below which it counts as silence
BANDS = (0.0, 1.0, 2.0, 4.0, 8.0, 12.5)  # hertz; speech opens and closes the mouth 2 to 8 times per second


def correlation(a: Curve, b: Curve) -> float:
    """Pearson's r of two curves, (frames,) each; NaN when one of them is constant."""
    if np.ptp(a) == 0 or np.ptp(b) == 0:
        return float("nan")
    a, b = a - a.mean(), b - b.mean()
    return float((a * b).sum()) / float(np.sqrt((a**2).sum() * (b**2).sum()))


def sd_ratio(predicted: Curve, captured: Curve) -> float:
    """Standard deviation of the predicted over that of the captured curve, (frames,) each; NaN for 0.

    A correlation does not see amplitude: below 1 the predicted mouth moves too little, above 1 too much.
    """
    if np.ptp(captured) == 0:
        return float("nan")
    return float(np.std(predicted) / np.std(captured))


def regression_slope(predicted: Curve, captured: Curve) -> float:
    """Slope of the predicted on the captured curve, (frames,) each: r times the ratio of deviations.

    It is how far the predicted mouth moves for each unit of captured motion; NaN for a constant capture.
    """
    if np.ptp(captured) == 0:
        return float("nan")
    away = captured - captured.mean()
    return float((away * (predicted - predicted.mean())).sum() / (away**2).sum())


def lag(predicted: Curve, captured: Curve, fps: float, reach: float = REACH) -> tuple[float, float]:
    """Delay of the predicted curve in seconds, and r at that shift; (frames,) each.

    d = argmax_d r(x_{t + d}, y_t) over whole frames |d| <= reach fps, refined by the parabola through the
    three r about the best. Positive: the prediction is late. NaN when a curve is constant.
    """
    most = min(round(reach * fps), len(captured) - 3)
    shifts = np.arange(-most, most + 1)
    found = np.array([_shifted(predicted, captured, int(shift)) for shift in shifts])
    if most < 0 or not np.isfinite(found).any():
        return float("nan"), float("nan")
    best = int(np.nanargmax(found))
    if not 0 < best < len(found) - 1 or not np.isfinite(found[best - 1 : best + 2]).all():
        return float(shifts[best] / fps), float(found[best])
    before, peak, after = found[best - 1 : best + 2]
    bend = before - 2 * peak + after
    offset = 0.5 * (before - after) / bend if bend < 0 else 0.0
    return float((shifts[best] + offset) / fps), float(peak)


def derivative_error(predicted: Curve, captured: Curve, fps: float, order: int = 1) -> float:
    """Root mean square error of speed (order 1, unit/s) or acceleration (order 2, unit/s²), (frames, ...).

    sqrt(mean (D^n x - D^n y)²) fps^n with D the difference from frame to frame. Its square over fps^(2n) is
    the loss L_v or L_a of Medina 2023, equations 4.11 and 4.13. Raises EvaluationError when there are not
    more frames than `order`.
    """
    apart = difference(predicted, captured)
    if len(apart) <= order:
        raise EvaluationError(
            f"{len(apart)} frames have no derivative of order {order}; give {order + 1} or more"
        )
    return float(np.sqrt(np.mean(np.diff(apart, n=order, axis=0) ** 2)) * fps**order)


def log_spectral_distance(predicted: Curve, captured: Curve, fps: float) -> float:
    """Root mean square difference of two power spectra in decibels, (frames,) each.

    sqrt(1/F sum_f (10 log10 P(f) / Q(f))²), bins of 1 Hz, without the mean (Gray and Markel 1976). Spectra
    are Welch's, floored 60 dB below their own largest bin. About 0 for motion as lively as the captured one,
    regardless of timing; large for stepped, jittery or sluggish motion; NaN when one curve is constant.
    Raises EvaluationError below 4 frames.
    """
    if np.ptp(predicted) == 0 or np.ptp(captured) == 0:
        return float("nan")
    decibels = [10 * np.log10(np.maximum(p, FLOOR * p.max())) for p in _spectra(predicted, captured, fps)]
    return float(np.sqrt(np.mean((decibels[0] - decibels[1]) ** 2)))


def band_energies(curve: Curve, fps: float, edges: tuple[float, ...] = BANDS) -> Array:
    """Mean square motion in frequency bands, (frames,) -> (bands,) in the unit squared.

    Band b is edges[b] <= f < edges[b + 1] hertz, the last one including its upper edge; the mean of each of
    Welch's sections is subtracted. The bands of a sine of amplitude a sum to a²/2.
    """
    power, frequencies = _welch(np.asarray(curve, np.float64), fps)
    band = np.searchsorted(edges, frequencies, side="right") - 1
    band[frequencies == edges[-1]] = len(edges) - 2
    kept = (band >= 0) & (band < len(edges) - 1)
    return np.bincount(band[kept], power[kept], minlength=len(edges) - 1).astype(np.float64)


def jerk(curve: Curve, fps: float) -> float:
    """Root mean square third derivative of a curve, (frames,) mm -> mm/s^3 (Flash and Hogan 1985)."""
    return float(np.sqrt(np.mean(np.diff(curve, n=3) ** 2)) * fps**3)


def _shifted(predicted: Curve, captured: Curve, shift: int) -> float:
    """R of predicted[t + shift] and captured[t] over the frames that exist in both."""
    count = min(len(predicted), len(captured)) - abs(shift)
    late, early = max(shift, 0), max(-shift, 0)
    return correlation(predicted[late : late + count], captured[early : early + count])


def _spectra(predicted: Curve, captured: Curve, fps: float) -> tuple[Array, Array]:
    """Power at every frequency except zero, with the same sections for both."""
    length = min(len(predicted), len(captured))
    first, second = (_welch(np.asarray(c[:length], np.float64), fps)[0][1:] for c in (predicted, captured))
    return first, second


def _welch(curve: Array, fps: float) -> tuple[Array, Array]:
    """One-sided power per bin and its frequencies in hertz: Hann sections, half overlapping (Welch 1967)."""
    if len(curve) < 4:
        raise EvaluationError(f"a spectrum needs 4 frames or more, not {len(curve)}")
    size = min(len(curve), max(4, round(SECTION * fps)))
    sections = np.lib.stride_tricks.sliding_window_view(curve, size)[:: size // 2]
    window = np.hanning(size + 1)[:-1]
    lines = np.fft.rfft((sections - sections.mean(axis=1, keepdims=True)) * window)
    power = (np.abs(lines) ** 2).mean(axis=0) / (size * (window**2).sum())
    power[1 : (size + 1) // 2] *= 2
    return np.asarray(power), np.fft.rfftfreq(size, 1 / fps).astype(np.float64)
