"""Move pixels with landmarks: piecewise-affine warps between pictures and one reference shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError
from phonanim.media.raster import rasterize

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Mesh:
    """Triangles between landmarks, and the pixels of a texture in them.

    `reference` (landmarks, 2) are texture pixels (right, down) on a grid of `height` x `width`; `triangles`
    (t, 3) are rows of landmarks. `pixels` (p,) are the flat grid indices inside a triangle, `corners` (p, 3)
    the landmarks around each and `weights` (p, 3) its barycentric coordinates.
    """

    reference: Array
    triangles: NDArray[np.int64]
    height: int
    width: int
    pixels: NDArray[np.int64]
    corners: NDArray[np.int64]
    weights: NDArray[np.float32]

    def places(self, landmarks: NDArray[np.floating]) -> NDArray[np.float32]:
        """Positions of the texture's pixels in pictures, (frames, landmarks, 2) -> (frames, p, 2)."""
        points = np.asarray(landmarks, np.float32)
        return np.asarray(sum(points[:, self.corners[:, k]] * self.weights[:, k, None] for k in range(3)))

    def cut(self, images: NDArray[Any], landmarks: NDArray[np.floating]) -> NDArray[np.float32]:
        """Textures of pictures, (frames, rows, columns, channels) -> (frames, p, channels).

        `landmarks` (frames, landmarks, 2) are pixels of the pictures, right and down.
        """
        return np.stack(
            [
                sample_bilinear(image, places)
                for image, places in zip(images, self.places(landmarks), strict=True)
            ]
        )

    def picture(self, texture: NDArray[np.floating]) -> NDArray[np.float32]:
        """A texture in the reference shape, (p, channels) -> (height, width, channels), 0 elsewhere."""
        image = np.zeros((self.height * self.width, texture.shape[1]), np.float32)
        image[self.pixels] = texture
        return image.reshape(self.height, self.width, -1)

    def draw(
        self, texture: NDArray[np.floating], landmarks: NDArray[np.floating], canvas: NDArray[np.uint8]
    ) -> NDArray[np.uint8]:
        """A canvas (rows, columns, channels) with a texture (p, channels) drawn at landmarks (landmarks, 2).

        Triangles that are turned over (crossed lips) are left out, so the canvas stays visible there.
        """
        flat = np.column_stack([landmarks, np.zeros(len(landmarks))]).astype(np.float32)
        seen = rasterize(flat, self.triangles, *canvas.shape[:2])
        covered = seen.covered()
        places = seen.at(covered, self.reference.astype(np.float32))
        values = sample_bilinear(self._bled(texture), places)
        drawn = canvas.copy()
        drawn.reshape(-1, canvas.shape[2])[covered] = np.clip(np.rint(values), 0, 255).astype(np.uint8)
        return drawn

    def _bled(self, texture: NDArray[np.floating]) -> NDArray[np.float32]:
        """The texture's picture with its border repeated outwards by a pixel, for interpolation there."""
        image, known = self.picture(texture), self.picture(np.ones((len(self.pixels), 1)))
        sums = [_shifted(image, y, x) for y in (-1, 0, 1) for x in (-1, 0, 1)]
        counts = [_shifted(known, y, x) for y in (-1, 0, 1) for x in (-1, 0, 1)]
        around = sum(sums) / np.maximum(sum(counts), 1)
        return np.asarray(np.where(known > 0, image, around), np.float32)


def _shifted(image: NDArray[np.float32], down: int, right: int) -> NDArray[np.float32]:
    return np.asarray(np.roll(image, (down, right), axis=(0, 1)))


def build_mesh(points: NDArray[np.floating], margin: int = 2) -> Mesh:
    """The Delaunay triangulation of a shape, (landmarks, 2) pixels right and down, and its pixels.

    The grid is as large as the shape and `margin` pixels more on every side.
    """
    reference = np.asarray(points, np.float64) - points.min(axis=0) + margin
    width, height = (int(v) for v in np.ceil(reference.max(axis=0)) + margin + 1)
    triangles = _facing(reference, _delaunay(reference))
    flat = np.column_stack([reference, np.zeros(len(reference))]).astype(np.float32)
    seen = rasterize(flat, triangles, height, width)
    pixels = seen.covered()
    faces = seen.face.ravel()[pixels]
    row, column = np.divmod(pixels, width)
    places = np.column_stack([column, row, np.ones(len(pixels))]).astype(np.float32)
    weights = np.einsum("pkj,pj->pk", seen.planes[faces], places)
    return Mesh(reference, triangles, height, width, pixels, seen.corners[faces], weights)


def _delaunay(points: Array) -> NDArray[np.int64]:
    try:
        from scipy.spatial import Delaunay
    except ImportError as error:
        raise MissingExtraError("an appearance model needs scipy: pip install 'phonanim[train]'") from error
    return np.asarray(Delaunay(points).simplices, np.int64)


def _facing(points: Array, triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles in a stable order, with the corners of each in the orientation that `rasterize` draws."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = (c - a)[:, 0] * (b - a)[:, 1] - (b - a)[:, 0] * (c - a)[:, 1]
    turned = np.where((area > 0)[:, None], triangles, triangles[:, ::-1])
    return np.asarray(turned[np.lexsort(np.sort(turned, axis=1).T)])


def sample_bilinear(image: NDArray[Any], places: NDArray[np.floating]) -> NDArray[np.float32]:
    """Bilinear values of a picture (rows, columns, channels) at positions (p, 2), -> (p, channels).

    Positions are pixels right and down; outside the picture its border is repeated.
    """
    rows, columns = image.shape[:2]
    x = np.clip(places[:, 0], 0, columns - 1).astype(np.float32)
    y = np.clip(places[:, 1], 0, rows - 1).astype(np.float32)
    left, top = np.minimum(x.astype(np.int64), columns - 2), np.minimum(y.astype(np.int64), rows - 2)
    across, down = (x - left)[:, None], (y - top)[:, None]
    flat, at = image.reshape(rows * columns, -1), top * columns + left
    upper = flat[at] * (1 - across) + flat[at + 1] * across
    lower = flat[at + columns] * (1 - across) + flat[at + columns + 1] * across
    return np.asarray(upper * (1 - down) + lower * down, np.float32)
