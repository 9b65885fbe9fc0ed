"""The reference face: a mean shape and its modes of variation (the shape half of an AAM)."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.core.exact import ordered_product
from phonanim.errors import ModelError

# Numbers in the MediaPipe face mesh of the landmarks that the package uses by name.
SUBNASALE = 2
UPPER_LIP_INNER, LOWER_LIP_INNER = 13, 14
UPPER_LIP_OUTER, LOWER_LIP_OUTER = 0, 17
MOUTH_CORNER_RIGHT, MOUTH_CORNER_LEFT = 61, 291
OUTER_LIPS = (61, 185, 40, 39, 37, 0, 267, 269, 270, 409, 291, 375, 321, 405, 314, 17, 84, 181, 91, 146)
INNER_LIPS = (78, 191, 80, 81, 82, 13, 312, 311, 310, 415, 308, 324, 318, 402, 317, 14, 87, 178, 88, 95)
# Opposite upper and lower inner-lip points, from the right corner to the left.
INNER_LIP_PAIRS = ((80, 88), (81, 178), (82, 87), (13, 14), (312, 317), (311, 402), (310, 318))

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FaceModel:
    """Linear shape model s = mean + sum_k p_k modes_k (Taylor 2017, section 4.1).

    `mean` is (landmarks, 3) mm, `modes` (m, landmarks, 3) orthonormal and largest first, `std`
    (m,) mm, the standard deviation of each parameter in the training clips, `indices` (landmarks,)
    the MediaPipe face-mesh number of each row. Origin between the eyes, x to the image's right,
    y up, z towards the camera, the pupils 63 mm apart. Landmarks above the upper lip are rigid:
    their modes are zero.
    """

    mean: Array
    modes: Array
    std: Array
    indices: NDArray[np.int64]

    kind: ClassVar[str] = "landmarks"

    @property
    def size(self) -> int:
        """Number of modes."""
        return len(self.std)

    def encode(self, frames: NDArray[np.floating], rest: Array | None = None) -> NDArray[np.float32]:
        """Rows that a regressor learns: parameters of the modes, (frames, landmarks, 3) -> (frames, m)."""
        return self.project(frames).astype(np.float32)

    def decode(self, rows: NDArray[np.floating], rest: Array | None = None) -> Array:
        """Landmarks of rows, (frames, m) -> (frames, landmarks, 3) mm."""
        return self.instance(rows)

    def project(self, shapes: NDArray[np.floating]) -> Array:
        """Shape parameters of shapes, (frames, landmarks, 3) mm -> (frames, m)."""
        flat = (np.asarray(shapes, np.float64) - self.mean).reshape(len(shapes), -1)
        return np.asarray(flat @ self._basis.T)

    def instance(self, parameters: NDArray[np.floating]) -> Array:
        """Shapes of parameters, (frames, m) -> (frames, landmarks, 3) mm."""
        flat = ordered_product(np.asarray(parameters, np.float64), self._basis)
        return self.mean + flat.reshape(-1, *self.mean.shape)

    def landmark(self, number: int) -> int:
        """Row of a MediaPipe face-mesh number. Raises ModelError when the face does not have it."""
        if number not in self._row_of:
            raise ModelError(f"the reference face has no landmark {number}; it has {self.indices.tolist()}")
        return self._row_of[number]

    def rows(self, numbers: Iterable[int]) -> NDArray[np.int64]:
        """Rows of several MediaPipe face-mesh numbers."""
        return np.array([self.landmark(number) for number in numbers])

    @cached_property
    def moving(self) -> NDArray[np.bool_]:
        """A mask of the landmarks that the modes move, (landmarks,); errors are measured on these."""
        moved: NDArray[np.bool_] = np.abs(self.modes).max(axis=(0, 2)) > 0
        return moved

    @cached_property
    def id(self) -> str:
        """Twelve hex digits that change with the modes; the poses of a rig are valid for one face only."""
        digest = hashlib.sha256()
        for part in (self.mean, self.modes, self.std):
            digest.update(part.astype("<f4").tobytes())  # as stored in model folders
        return digest.hexdigest()[:12]

    @cached_property
    def _row_of(self) -> dict[int, int]:
        """The first row of each number."""
        rows = enumerate(self.indices.tolist())
        return {number: row for row, number in reversed([*rows])}

    @cached_property
    def _basis(self) -> Array:
        return self.modes.reshape(len(self.modes), -1)


def lip_aperture(shapes: NDArray[np.floating], face: FaceModel) -> Array:
    """Gap between the middles of the inner lips, (frames, landmarks, 3) -> (frames,) mm."""
    upper, lower = face.rows((UPPER_LIP_INNER, LOWER_LIP_INNER))
    return np.asarray(shapes[:, upper, 1] - shapes[:, lower, 1], np.float64)


def lip_width(shapes: NDArray[np.floating], face: FaceModel) -> Array:
    """Distance between the mouth corners, (frames, landmarks, 3) -> (frames,) mm."""
    right, left = face.rows((MOUTH_CORNER_RIGHT, MOUTH_CORNER_LEFT))
    return np.asarray(np.linalg.norm(shapes[:, left] - shapes[:, right], axis=1), np.float64)


def lip_protrusion(shapes: NDArray[np.floating], face: FaceModel) -> Array:
    """Mean forward position of the outer lips' middles, (frames, landmarks, 3) -> (frames,) mm."""
    return np.asarray(shapes[:, face.rows((UPPER_LIP_OUTER, LOWER_LIP_OUTER)), 2].mean(axis=1), np.float64)
