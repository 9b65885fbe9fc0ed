"""Measures of tongue and jaw: width, curvature, speed, and the envelope (Medina 2023, chapter 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.ema.articulation import Articulation
from phonanim.ema.preparation import resample_sensors

Array = NDArray[np.float64]
CUTOFF = 20.0  # hertz; speech is slower, and a derivative would amplify the noise above
VIEWS = {"front": (1, 2), "side": (0, 2), "top": (0, 1)}  # axes of the planes of the views


def tongue_width(articulation: Articulation) -> Array:
    """Distance of the sensors left and right on the blade, |BL - BR|, (samples,) mm. Raises CorpusError.

    Source: Medina 2023, section 2.2.2.
    """
    apart = articulation.sensor("BL") - articulation.sensor("BR")
    return np.asarray(np.linalg.norm(apart, axis=1))


def tongue_curvature(articulation: Articulation) -> Array:
    """Signed Menger curvature of BL, TB, BR seen from the front, (samples,) 1/mm. Raises CorpusError.

    c = 4 A / (|a - b| |b - c| |c - a|) of the points (y, z), A the area of their triangle: one over the
    radius of the circle through them. Positive where the edges curl down, negative where they curl up, 0 for
    a flat tongue. Source: Medina 2023, section 2.2.2; Leger 1999, Menger curvature.
    """
    left, middle, right = (articulation.sensor(name)[:, 1:] for name in ("BL", "TB", "BR"))
    return menger_curvature(left, middle, right)


def menger_curvature(a: Array, b: Array, c: Array) -> Array:
    """Signed curvature of three points of a plane, (samples, 2) each -> (samples,), per unit of length.

    Positive for a left turn on the way from a over b to c. NaN where two points coincide.
    """
    ab, bc, ca = b - a, c - b, a - c
    doubled = ab[:, 0] * bc[:, 1] - ab[:, 1] * bc[:, 0]  # twice the signed area
    with np.errstate(invalid="ignore", divide="ignore"):
        product = np.prod([np.linalg.norm(side, axis=1) for side in (ab, bc, ca)], axis=0)
        return np.asarray(np.where(product > 0, 2 * doubled / product, np.nan))


def speeds(articulation: Articulation, cutoff: float = CUTOFF) -> Array:
    """|dp/dt| of every sensor, (samples, sensors) mm/s: central differences below `cutoff` hertz.

    Source: Medina 2023, section 2.2.3, which takes their peaks and does not describe a filter.
    """
    smooth = resample_sensors(articulation, articulation.rate, cutoff).positions
    if len(smooth) < 2:
        return np.full(smooth.shape[:2], np.nan)
    return np.asarray(np.linalg.norm(np.gradient(smooth, 1 / articulation.rate, axis=0), axis=2))


@dataclass(frozen=True)
class Envelope:
    """The range of a sensor: its `reach` (forward, left, up) in mm, `outlines` and `areas` of three views.

    `outlines` are the convex hulls from the front, the side and the top, (corners, 2) mm each; `areas` mm².
    """

    reach: tuple[float, float, float]
    outlines: dict[str, Array]
    areas: dict[str, float]


def envelope(points: Array) -> Envelope:
    """The envelope of positions of the jaw, (samples, 3) mm; NaN is left out.

    Source: Medina 2023, section 2.3, after Posselt 1952. Speech uses a small part of a jaw's range.
    """
    tracked = points[np.isfinite(points).all(axis=1)]
    forward, left, up = np.ptp(tracked, axis=0).tolist() if len(tracked) else (0.0, 0.0, 0.0)
    outlines = {view: convex_hull(tracked[:, axes]) for view, axes in VIEWS.items()}
    areas = {view: polygon_area(outline) for view, outline in outlines.items()}
    return Envelope((forward, left, up), outlines, areas)


def convex_hull(points: Array) -> Array:
    """Corners of the convex hull, counterclockwise, (n, 2) -> (corners, 2) (Andrew 1979, monotone chain)."""
    ordered = np.unique(points, axis=0)
    if len(ordered) < 3:
        return ordered
    lower, upper = _chain(ordered), _chain(ordered[::-1])
    return np.array(lower[:-1] + upper[:-1])


def _chain(points: Array) -> list[list[float]]:
    chain: list[list[float]] = []
    for x, y in points.tolist():
        while len(chain) > 1 and _turn(chain[-2], chain[-1], x, y) <= 0:
            chain.pop()
        chain.append([x, y])
    return chain


def _turn(a: list[float], b: list[float], x: float, y: float) -> float:
    """Positive for a left turn on the way from a over b to (x, y)."""
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])


def polygon_area(corners: Array) -> float:
    """Area of a polygon, (corners, 2) -> square units (the shoelace formula)."""
    x, y = corners.T
    return float(abs((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) / 2)
