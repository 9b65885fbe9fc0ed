"""A small z-buffer: the visible triangle at each pixel, and vertex values interpolated there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

EMPTY = -1
SMALLEST = 1e-6  # square pixels: thinner triangles are seen edge-on and skipped


@dataclass(frozen=True)
class Picture:
    """The content of a view: `face` (height, width) is the row of `corners` at each pixel, or EMPTY.

    `depth` (height, width) rises towards the viewer and is -inf at empty pixels; `corners` (t, 3) are the
    triangles that face the viewer; `planes` (t, 3, 3) gives the three corner weights of a triangle at a
    pixel as planes · (x, y, 1).
    """

    face: NDArray[np.int32]
    depth: NDArray[np.float32]
    corners: NDArray[np.int64]
    planes: NDArray[np.float32]

    def covered(self) -> NDArray[np.int64]:
        """Flat indices of the pixels that are not empty, (p,)."""
        return np.flatnonzero(self.face.ravel() != EMPTY)

    def at(self, pixels: NDArray[np.int64], values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Vertex values interpolated at pixels, (n, k) -> (p, k)."""
        faces = self.face.ravel()[pixels]
        row, column = np.divmod(pixels, self.face.shape[1])
        across, down, start = np.einsum("tck,tcj->jtk", values[self.corners], self.planes)
        result: NDArray[np.float32] = across.take(faces, axis=0) * column.astype(np.float32)[:, None]
        result += down.take(faces, axis=0) * row.astype(np.float32)[:, None]
        result += start.take(faces, axis=0)
        return result


def rasterize(points: NDArray[np.float32], triangles: NDArray[np.int64], height: int, width: int) -> Picture:
    """Draw triangles into a z-buffer. Points are (n, 3): pixels right, pixels down and nearness.

    Triangles with clockwise corners on screen face away and are left out.
    """
    x, y = points[:, 0], points[:, 1]
    corners, planes = _facing(x, y, triangles)
    first, last = _rows(y[corners], height)
    seen = last >= first
    corners, planes, first, last = corners[seen], planes[seen], first[seen], last[seen]
    slopes = np.einsum("tcj,tc->tj", planes, points[corners, 2])
    face, pixels, depths = _fragments(x, y, corners, slopes, first, last, width)
    nearest = np.full(height * width, -np.inf, np.float32)
    np.maximum.at(nearest, pixels, depths)
    front = depths == nearest[pixels]
    shown = np.full(height * width, EMPTY, np.int32)
    shown[pixels[front]] = face[front]
    return Picture(shown.reshape(height, width), nearest.reshape(height, width), corners, planes)


def _facing(
    x: NDArray[np.float32], y: NDArray[np.float32], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """The triangles that face the viewer, and the planes of their corner weights."""
    (ax, bx, cx), (ay, by, cy) = x[triangles].T, y[triangles].T
    area = (cx - ax) * (by - ay) - (bx - ax) * (cy - ay)
    facing = area > SMALLEST
    ax, bx, cx, ay, by, cy, area = (v[facing] for v in (ax, bx, cx, ay, by, cy, area))
    rows = [
        ((cy - by), (bx - cx), (by * cx - bx * cy)),
        ((ay - cy), (cx - ax), (cy * ax - cx * ay)),
        ((by - ay), (ax - bx), (ay * bx - ax * by)),
    ]
    planes = np.moveaxis(np.array(rows) / area, -1, 0)
    return triangles[facing], planes.astype(np.float32)


def _rows(y: NDArray[np.float32], height: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and last pixel row whose centre each triangle reaches, (t, 3) -> (t,), (t,)."""
    first = np.clip(np.ceil(y.min(axis=1)), 0, height).astype(np.int64)
    last = np.clip(np.floor(y.max(axis=1)), -1, height - 1).astype(np.int64)
    return first, last


def _fragments(
    x: NDArray[np.float32],
    y: NDArray[np.float32],
    corners: NDArray[np.int64],
    slopes: NDArray[np.float32],
    first: NDArray[np.int64],
    last: NDArray[np.int64],
    width: int,
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Every pixel of every triangle: triangle, flat pixel index and depth, by spans along the rows."""
    face, step = _spread(last - first + 1)
    row = first[face] + step
    left, right = _span(x[corners], y[corners], face, row.astype(np.float32))
    start = np.clip(np.ceil(left), 0, width).astype(np.int64)
    stop = np.clip(np.floor(right), -1, width - 1).astype(np.int64)
    span, column = _spread(np.maximum(stop - start + 1, 0))
    begin = slopes[face, 0] * start + slopes[face, 1] * row + slopes[face, 2]
    depths = begin[span] + slopes[face, 0][span] * column
    return face[span], (row * width + start)[span] + column, depths.astype(np.float32)


def _span(
    x: NDArray[np.float32], y: NDArray[np.float32], face: NDArray[np.int64], row: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Where a row enters and leaves its triangle: the row crosses two of the three edges."""
    left = np.full(len(row), np.inf, np.float32)
    right = -left
    for a, b in ((0, 1), (1, 2), (2, 0)):
        rise = y[:, b] - y[:, a]
        slope = (x[:, b] - x[:, a]) / np.where(rise == 0, np.float32(1), rise)
        top, bottom = np.minimum(y[:, a], y[:, b]), np.maximum(y[:, a], y[:, b])
        crossed = (row >= top[face]) & (row <= bottom[face]) & (rise[face] != 0)
        crossing = x[face, a] + slope[face] * (row - y[face, a])
        left = np.where(crossed, np.minimum(left, crossing), left)
        right = np.where(crossed, np.maximum(right, crossing), right)
    return left, right


def _spread(counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Item and index within the item, repeated counts[i] times each: [2, 1] -> [0, 0, 1], [0, 1, 0]."""
    item = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(item)) - np.repeat(np.cumsum(counts) - counts, counts)
    return item, place
