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
UPPER_OUTER = (185, 40, 39, 37, 0, 267, 269, 270, 409)
LOWER_OUTER = (146, 91, 181, 84, 17, 314, 405, 321, 375)
# Where the inner lips' landmarks lie between the corners, as on the shipped head.
ACROSS = np.array([0.13, 0.19, 0.28, 0.38, 0.50, 0.62, 0.72, 0.81, 0.87])
OPENED = 0.15  # more of the motion of an opening mouth below a slit than above it
FAR = 0.015  # metres above and below the line between the corners in which the slit is sought
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


def put_on_rims(
    points: Array, triangles: NDArray[np.int64], landmarks: MeshLandmarks, opening: Array | None = None
) -> MeshLandmarks:
    """Move the inner-lip landmarks to the rims, on a skin in metres that looks along z with y up.

    `opening` (points,) is how far each point goes as the mouth opens, from 0 to 1: the slit is then sought
    where what is below opens and what is above does not, even where the landmarks are not near. Landmarks of
    the outer lips go along with inner ones that were far.
    """
    mouth = landmarks.take((61, 291)).of(points)
    view = View(20_000.0, mouth.mean(axis=0), (800.0, 600.0), 1200, 1600)  # twenty pixels to the millimetre
    picture = view.show(points, triangles)
    rows = _rows_of(landmarks, UPPER_INNER + LOWER_INNER)
    seen = view.pixels(landmarks.of(points)[rows])[:, :2]
    before = seen.copy()
    if opening is not None:
        _seek_slit(seen, picture, points, opening, view.pixels(mouth)[:, :2], round(FAR * view.scale))
    reach = round(REACH * view.scale)
    for number, spot in enumerate(seen):
        near = np.arange(round(spot[1]) - reach, round(spot[1]) + reach).clip(0, view.height - 1)
        column = int(np.clip(round(spot[0]), 0, view.width - 1))
        gaps = near[1:][_torn(picture, points, near, column)]
        if len(gaps) == 0:  # one closed surface: its deepest point is the crease
            gaps = near[[picture.depth[near, column].argmin()]]
        spot[1] = gaps[0] - 1 if number < len(UPPER_INNER) else gaps[-1]
    far = np.flatnonzero(np.abs(seen - before).max(axis=1) > reach)
    outer = _rows_of(landmarks, UPPER_OUTER + LOWER_OUTER)[far]
    along = view.pixels(landmarks.of(points)[outer])[:, :2]
    along = np.column_stack([seen[far, 0], along[:, 1] + (seen - before)[far, 1]])
    corners, weights = landmarks.corners.copy(), landmarks.weights.copy()
    moved, places = np.concatenate([rows, outer]), np.concatenate([seen, along])
    corners[moved], weights[moved] = surface_at_pixels(view, picture, places)
    return MeshLandmarks(landmarks.numbers, corners, weights)


def _rows_of(landmarks: MeshLandmarks, numbers: tuple[int, ...]) -> NDArray[np.int64]:
    place = {int(number): row for row, number in enumerate(landmarks.numbers)}
    return np.array([place[number] for number in numbers])


def _seek_slit(
    seen: Array, picture: Picture, points: Array, opening: Array, mouth: Array, reach: int
) -> None:
    """Bring the pixels of inner lips, (18, 2), to the tear below which the mouth opens most, in place.

    It is sought up and down from the line between the two corners of the `mouth`. Columns without such a tear
    are left.
    """
    shares = np.tile(ACROSS, 2)
    columns = np.rint(mouth[0, 0] + shares * (mouth[1, 0] - mouth[0, 0])).astype(int)
    lines = np.rint(mouth[0, 1] + shares * (mouth[1, 1] - mouth[0, 1])).astype(int)
    height, width = picture.face.shape
    for spot, column, line in zip(seen, columns.clip(0, width - 1), lines, strict=True):
        near = np.arange(line - reach, line + reach).clip(0, height - 1)
        faces = picture.face[near, column]
        opened = np.where(faces == EMPTY, 0.0, opening[picture.corners[faces]].mean(axis=1))
        gained = np.where(_torn(picture, points, near, column), opened[1:] - opened[:-1], 0.0)
        if gained.max() > OPENED:
            spot[:] = column, near[gained.argmax() + 1]


def _torn(picture: Picture, points: Array, rows: NDArray[np.int64], column: int) -> NDArray[np.bool_]:
    """Where neighbouring pixels of a column show triangles that do not touch, (rows - 1,).

    One lip is in front of the other, or of the slit, only where the visible surface is discontinuous.
    """
    faces = picture.face[rows, column]
    corners = points[picture.corners[faces]]
    apart = np.linalg.norm(corners[1:, :, None] - corners[:-1, None], axis=3).min(axis=(1, 2))
    slit = faces == EMPTY
    return np.where(slit[1:] | slit[:-1], slit[1:] != slit[:-1], apart > TOUCHING)
