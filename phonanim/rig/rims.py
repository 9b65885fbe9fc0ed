"""Move inner-lip landmarks to the rims of the lips, which meet when the mouth is closed.

Neither a tracker nor a warp can separate two rims in a closed mouth. A view of the lips from the front can:
where one lip ends, the visible surface is discontinuous.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.media.raster import EMPTY, Picture, rasterize
from phonanim.rig.landmarks import MeshLandmarks

Array = NDArray[np.float64]

UPPER_INNER = (191, 80, 81, 82, 13, 312, 311, 310, 415)
LOWER_INNER = (95, 88, 178, 87, 14, 317, 402, 318, 324)
TOUCHING = 1e-6  # metres: vertices nearer than this are one
REACH = 0.003  # metres up and down in which the rim is searched


@dataclass(frozen=True)
class View:
    """An orthographic front view: pixels per metre; the position (metres) and the pixel of its centre."""

    scale: float
    middle: Array
    centre: tuple[float, float]
    height: int
    width: int

    def pixels(self, points: Array) -> Array:
        """Column, row and nearness (depth) of points, (n, 3) metres -> (n, 3)."""
        return np.asarray((points - self.middle) * self.scale * (1, -1, 1) + (*self.centre, 0))

    def show(self, points: Array, triangles: NDArray[np.int64]) -> Picture:
        """The visible part of a surface."""
        return rasterize(self.pixels(points).astype(np.float32), triangles, self.height, self.width)


def surface_at_pixels(view: View, picture: Picture, seen: Array) -> tuple[NDArray[np.int64], Array]:
    """The surface at each pixel, or at the nearest covered pixel: corners and weights, (n, 3) each."""
    place = np.rint(seen).astype(np.int64).clip(0, (view.width - 1, view.height - 1))
    missed = np.flatnonzero(picture.face[place[:, 1], place[:, 0]] == EMPTY)
    if len(missed):
        covered = np.column_stack(np.divmod(picture.covered(), view.width))[:, ::-1]
        place[missed] = [covered[((covered - seen[row]) ** 2).sum(axis=1).argmin()] for row in missed]
    face = picture.face[place[:, 1], place[:, 0]]
    inside = np.linalg.norm(place - seen, axis=1) < 1
    spot = np.column_stack([np.where(inside[:, None], seen, place), np.ones(len(seen))])
    weights = np.einsum("ncj,nj->nc", picture.planes[face].astype(float), spot).clip(0)
    return picture.corners[face], weights / weights.sum(axis=1, keepdims=True)


def put_on_rims(points: Array, triangles: NDArray[np.int64], landmarks: MeshLandmarks) -> MeshLandmarks:
    """Move the inner-lip landmarks to the rims, on a skin in metres that looks along z with y up."""
    mouth = landmarks.take((61, 291)).of(points)
    view = View(20_000.0, mouth.mean(axis=0), (800.0, 400.0), 800, 1600)  # twenty pixels to the millimetre
    picture = view.show(points, triangles)
    rows = np.flatnonzero(np.isin(landmarks.numbers, UPPER_INNER + LOWER_INNER))
    seen = view.pixels(landmarks.of(points)[rows])[:, :2]
    upper = np.isin(landmarks.numbers[rows], UPPER_INNER)
    reach = round(REACH * view.scale)
    for spot, above in zip(seen, upper, strict=True):
        near = np.arange(round(spot[1]) - reach, round(spot[1]) + reach)
        column = round(spot[0])
        gaps = near[1:][_torn(picture, points, near, column)]
        if len(gaps) == 0:  # one closed surface: its deepest point is the crease
            gaps = near[[picture.depth[near, column].argmin()]]
        spot[1] = gaps[0] - 1 if above else gaps[-1]
    corners, weights = landmarks.corners.copy(), landmarks.weights.copy()
    corners[rows], weights[rows] = surface_at_pixels(view, picture, seen)
    return MeshLandmarks(landmarks.numbers, corners, weights)


def _torn(picture: Picture, points: Array, rows: NDArray[np.int64], column: int) -> NDArray[np.bool_]:
    """Where neighbouring pixels of a column show triangles that do not touch, (rows - 1,).

    One lip is in front of the other, or of the slit, only where the visible surface is discontinuous.
    """
    faces = picture.face[rows, column]
    corners = points[picture.corners[faces]]
    apart = np.linalg.norm(corners[1:, :, None] - corners[:-1, None], axis=3).min(axis=(1, 2))
    slit = faces == EMPTY
    return np.where(slit[1:] | slit[:-1], slit[1:] != slit[:-1], apart > TOUCHING)
