"""A mesh that moves, of a model of vertices: frames as an array, or as an animated GLB."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import atomic_path
from phonanim.errors import OutputError
from phonanim.media.mesh_glb import mesh_glb
from phonanim.targets.vertices import components

Array = NDArray[np.float64]
SUFFIXES = (".npy", ".glb")
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
LARGEST = {"m": 3.0, "cm": 60.0}  # of a head, in that unit
FITTED = 600  # frames that the directions of a GLB are fitted on
DIRECTIONS = 80


def check_mesh_output(path: Path, triangles: NDArray[np.int64] | None) -> None:
    """Raise OutputError for another suffix, and for a GLB without triangles."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise OutputError(f"{path}: a moving mesh is written as {' or '.join(SUFFIXES)}")
    if suffix == ".glb" and triangles is None:
        raise OutputError(
            f"{path}: the triangles of the mesh are not known; give a face of it as a mesh (--template "
            "face.obj or .ply), or write .npy"
        )


@dataclass(frozen=True)
class MeshMotion:
    """`points` (frames, vertices, 3) at n / fps seconds, in `unit`.

    `rest` (vertices, 3) is the face at rest, `triangles` (n, 3) are rows of vertices, if known.
    """

    points: NDArray[np.float32]
    fps: float
    rest: Array
    triangles: NDArray[np.int64] | None = None
    unit: str = ""

    def save(self, path: Path) -> tuple[str, ...]:
        """Write .npy or .glb, and return notes. Raises OutputError for other suffixes, or no triangles."""
        check_mesh_output(path, self.triangles)
        if path.suffix.lower() == ".npy":
            with atomic_path(path) as partial, partial.open("wb") as file:
                np.save(file, self.points)
            return ()
        assert self.triangles is not None
        scale, notes = self.metres()
        moved = (self.points - self.rest.astype(np.float32)).reshape(len(self.points), -1)
        every = -(-len(moved) // FITTED)
        mean, modes = components(moved[::every], DIRECTIONS)
        weights = (moved - mean) @ modes.T
        # The mean of the motion is a direction, too, whose weight is always 1.
        weights = np.column_stack([np.ones(len(moved), np.float32), weights])
        targets = np.concatenate([mean[None], modes])
        apart = float(np.abs(moved - weights @ targets).max()) * scale * 1000
        shapes = (targets * scale).reshape(len(targets), -1, 3)
        with atomic_path(path) as partial:
            partial.write_bytes(
                mesh_glb(self.rest * scale, self.triangles, shapes, weights, self.fps, path.stem)
            )
        told = (
            f"{path.name}: {len(targets)} morph targets, at most {apart:.2g} mm from the predicted vertices"
        )
        return (*notes, told)

    def metres(self) -> tuple[float, tuple[str, ...]]:
        """Metres per unit, by its name or by the size of the mesh, and a note on a guess."""
        if self.unit in METRES:
            return METRES[self.unit], ()
        size = float(np.ptp(self.rest, axis=0).max())
        guess = next((name for name, largest in LARGEST.items() if size < largest), "mm")
        return METRES[guess], (f"the mesh is {size:.3g} units high or wide: taken as {guess}",)
