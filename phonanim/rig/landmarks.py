"""Landmarks of the reference face as points on a mesh: a triangle's corners and barycentric weights."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError
from phonanim.core.files import write_text
from phonanim.core.lexicon import LEXICON
from phonanim.core.tables import parse_cell, read_rows
from phonanim.errors import RigError

Array = NDArray[np.float64]
SHIPPED = LEXICON / "rigs" / "arkit.landmarks.csv"
MARK = "phonanim rig landmarks, then --landmarks with the points"
"""What messages say to do where a face is not found."""
HEADER = ("landmark", "vertex_a", "vertex_b", "vertex_c", "weight_a", "weight_b", "weight_c")
MOST_VERTICES = 1e8  # of a number of a vertex


@dataclass(frozen=True)
class MeshLandmarks:
    """The position of each landmark of the face on a mesh.

    `numbers` (landmarks,) are MediaPipe face-mesh numbers, `corners` (landmarks, 3) vertex rows and
    `weights` (landmarks, 3) barycentric weights that sum to one.
    """

    numbers: NDArray[np.int64]
    corners: NDArray[np.int64]
    weights: Array

    def of(self, points: Array) -> Array:
        """Landmarks of vertices or of their deltas, (..., vertices, 3) -> (..., landmarks, 3)."""
        corners = np.asarray(points)[..., self.corners, :]
        return np.asarray((corners * self.weights[:, :, None]).sum(axis=-2), np.float64)

    def take(self, numbers: Iterable[int]) -> MeshLandmarks:
        """Only these landmarks, in this order. Raises RigError naming one that is missing."""
        place = {int(number): row for row, number in enumerate(self.numbers)}
        wanted = list(numbers)
        missing = [number for number in wanted if number not in place]
        if missing:
            raise RigError(f"the mesh has no landmark {missing[0]}; add its row to the landmark table")
        rows = np.array([place[number] for number in wanted])
        return MeshLandmarks(self.numbers[rows], self.corners[rows], self.weights[rows])


def shipped_landmarks() -> MeshLandmarks:
    """All 478 of MediaPipe's points on the shipped head."""
    return read_landmarks(SHIPPED)


def read_landmarks(path: Path) -> MeshLandmarks:
    """Read a landmark table (CSV). Raises RigError naming the file and the row."""
    try:
        rows = read_rows(path)
    except (OSError, DecodeError) as error:
        raise RigError(f"{path}: cannot be read: {error}") from error
    if not rows or tuple(rows[0]) != HEADER:
        raise RigError(f"{path}: must begin with the header {','.join(HEADER)}")
    numbers = [_parse(path, number, row) for number, row in enumerate(rows[1:], start=2)]
    table = np.array(numbers, np.float64).reshape(-1, len(HEADER))
    return MeshLandmarks(table[:, 0].astype(np.int64), table[:, 1:4].astype(np.int64), table[:, 4:])


def _parse(path: Path, line: int, row: list[str]) -> list[float]:
    try:
        values = [parse_cell(cell, name, 0, MOST_VERTICES) for name, cell in zip(HEADER, row, strict=True)]
    except ValueError as error:
        raise RigError(f"{path}, line {line}: {error}; write numbers alone") from error
    if not np.isclose(sum(values[4:]), 1.0, atol=1e-3):
        raise RigError(f"{path}, line {line}: needs a landmark, three vertices and three weights of sum 1")
    return values


def write_landmarks(path: Path, landmarks: MeshLandmarks) -> None:
    """Write a landmark table atomically."""
    columns = zip(landmarks.numbers, landmarks.corners, landmarks.weights, strict=True)
    lines = [",".join(HEADER)]
    for number, corners, weights in columns:
        cells = [str(number), *map(str, corners), *(f"{weight:.4f}" for weight in _rounded(weights))]
        lines.append(",".join(cells))
    write_text(path, "\n".join(lines) + "\n")


def _rounded(weights: Array) -> Array:
    """Weights rounded to four digits that still sum to exactly one."""
    kept = np.round(weights, 4)
    kept[np.argmax(kept)] += 1.0 - kept.sum()
    return kept
