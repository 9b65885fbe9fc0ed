"""Landmarks in millimetres from two or more calibrated views, by the direct linear transformation.

Medina (2023), section 4.1.1; Hartley and Zisserman (2004), chapters 7.1 and 12.2. A camera is a matrix P
(3, 4) that maps a point X to its picture p: p = P X in homogeneous coordinates (eq. 4.7).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError, read_array
from phonanim.core.tables import read_rows
from phonanim.errors import CorpusError

Array = NDArray[np.float64]
LEAST = 6  # known points that determine a camera
FLAT = 1e-4  # smallest extent of the known points, relative to the largest
NEAR = 1e-3  # smallest distance between cameras, relative to that of the known points
POINT = ("x", "y", "z")


@dataclass(frozen=True)
class Reconstruction:
    """Points (frames, points, 3) in the unit of the known points, NaN where fewer than two views see one.

    `apart` (views, frames, points) is the distance in pixels between what a view saw and where the point
    would appear in it.
    """

    points: Array
    apart: Array

    def facts(self, kept: Reconstruction) -> dict[str, Any]:
        """How many points are kept, unseen and left out, and the root mean square distance in pixels."""
        there, left = np.isfinite(self.points[..., 0]), np.isfinite(kept.points[..., 0])
        counts = {"points": left.sum(), "unseen": (~there).sum(), "left_out": (there & ~left).sum()}
        apart = (
            np.sqrt((self.apart[:, there] ** 2)[np.isfinite(self.apart[:, there])].mean())
            if there.any()
            else 0
        )
        return {name: int(count) for name, count in counts.items()} | {"apart_px": float(apart)}


def calibrate_camera(known: Array, seen: Array) -> Array:
    """The camera that maps known points to what it saw, (n, 3) and (n, 2) pixels -> (3, 4), norm 1.

    Raises CorpusError with fewer than six points, or when they all lie in one plane.
    """
    usable = np.isfinite(known).all(axis=1) & np.isfinite(seen).all(axis=1)
    known, seen = known[usable], seen[usable]
    if len(known) < LEAST:
        raise CorpusError(f"a camera needs {LEAST} known points, and only {len(known)} are seen; add some")
    extents = np.linalg.svd(known - known.mean(axis=0), compute_uv=False)
    if extents[2] < FLAT * extents[0]:
        raise CorpusError("the known points lie in one plane, which determines no camera; add some before it")
    from_world, from_picture = _normalizing(known), _normalizing(seen)
    points = _homogeneous(known) @ from_world.T
    u, v = (_homogeneous(seen) @ from_picture.T)[:, :2].T
    zero = np.zeros_like(points)
    rows = np.concatenate(
        [
            np.concatenate([points, zero, -u[:, None] * points], axis=1),
            np.concatenate([zero, points, -v[:, None] * points], axis=1),
        ]
    )
    camera = np.linalg.inv(from_picture) @ np.linalg.svd(rows)[2][-1].reshape(3, 4) @ from_world
    depths = _homogeneous(known) @ camera[2]
    return np.asarray(camera / np.linalg.norm(camera) * np.sign(np.median(depths)))


def calibrate_cameras(path: Path, views: int) -> tuple[list[Array], list[float]]:
    """The cameras of a calibration table, and the error of each in pixels.

    Raises CorpusError, which names the file and the view, and when all cameras are at one place, from which
    no depth is seen.
    """
    known, seen = read_calibration(path, views)
    cameras = []
    for number, view in enumerate(seen, 1):
        try:
            cameras.append(calibrate_camera(known, view))
        except CorpusError as error:
            raise CorpusError(f"{path}, view {number}: {error}") from error
    places = np.stack([-np.linalg.pinv(camera[:, :3]) @ camera[:, 3] for camera in cameras])
    far = np.linalg.norm(places - np.nanmean(known, axis=0), axis=1).min()
    if np.linalg.norm(places - places[0], axis=1).max() < NEAR * far:
        raise CorpusError(f"{path}: all views are from one place, which shows no depth; check the columns")
    return cameras, [calibration_error(one, known, view) for one, view in zip(cameras, seen, strict=True)]


def project_points(camera: Array, points: Array) -> Array:
    """Where points appear, (..., 3) -> (..., 2) pixels."""
    found = points @ camera[:, :3].T + camera[:, 3]
    return np.asarray(found[..., :2] / found[..., 2:])


def calibration_error(camera: Array, known: Array, seen: Array) -> float:
    """Root mean square distance in pixels between known points through a camera and what it saw."""
    return float(np.sqrt(np.nanmean(((project_points(camera, known) - seen) ** 2).sum(axis=1))))


def reconstruct(cameras: Sequence[Array], views: Sequence[Array]) -> Reconstruction:
    """Points from what each camera saw, (frames, points, 2) pixels each, NaN where it saw nothing.

    Each view gives two linear equations for a point, of which the least squares solution is taken. They are
    weighted by the point's depth in each camera, once, which makes the errors those of pixels.
    """
    seen = np.stack(views)
    points = _solve(cameras, seen, np.ones(seen.shape[:-1]))
    depths = np.stack([points @ camera[2, :3] + camera[2, 3] for camera in cameras])
    points = _solve(cameras, seen, 1 / np.where(np.abs(depths) > 0, depths, 1))
    apart = np.stack([project_points(camera, points) for camera in cameras]) - seen
    return Reconstruction(points, np.linalg.norm(apart, axis=-1))


def _solve(cameras: Sequence[Array], seen: Array, weights: Array) -> Array:
    rows = []
    for camera, view, weight in zip(cameras, seen, weights, strict=True):
        for axis in (0, 1):
            row = (view[..., axis, None] * camera[2] - camera[axis]) * weight[..., None]
            rows.append(np.nan_to_num(row))
    system = np.stack(rows, axis=-2)
    squares = system[..., :3].swapaxes(-1, -2) @ system[..., :3]
    wanted = -(system[..., :3] * system[..., 3:]).sum(axis=-2)
    enough = np.isfinite(seen).all(axis=-1).sum(axis=0) > 1
    found = np.full(wanted.shape, np.nan)
    found[enough] = np.linalg.solve(squares[enough], wanted[enough][..., None])[..., 0]
    return found


def drop_outliers(found: Reconstruction, largest: float) -> Reconstruction:
    """The same without points that lie more than `largest` pixels from what a view saw."""
    bad = np.nanmax(np.nan_to_num(found.apart), axis=0) > largest
    return Reconstruction(np.where(bad[..., None], np.nan, found.points), found.apart)


def read_calibration(path: Path, views: int) -> tuple[Array, list[Array]]:
    """Known points and where each view saw them: a table with columns x, y, z and u1, v1, u2, v2 ...

    -> (n, 3), and for each view (n, 2) pixels; an empty cell is a point that the view did not see. Raises
    CorpusError, which names the file, and the column or the line.
    """
    columns = [*POINT, *(f"{axis}{view + 1}" for view in range(views) for axis in "uv")]
    try:
        header, *cells = read_rows(path) or [[]]
    except (OSError, DecodeError) as error:
        raise CorpusError(f"{path}: cannot be read as a table ({error})") from error
    missing = [column for column in columns if column not in header]
    if missing:
        raise CorpusError(f"{path}: lacks the column {missing[0]!r}; it needs {', '.join(columns)}")
    places = [header.index(column) for column in columns]
    rows = [
        [_number(row[place] if place < len(row) else "", path, line) for place in places]
        for line, row in enumerate(cells, 2)
        if any(row)
    ]
    values = np.array(rows, np.float64).reshape(-1, len(columns))
    return values[:, :3], [values[:, 3 + 2 * view : 5 + 2 * view] for view in range(views)]


def _number(text: str | None, path: Path, line: int) -> float:
    if not text or not text.strip():
        return np.nan
    try:
        return float(text)
    except ValueError as error:
        raise CorpusError(f"{path}, line {line}: {text!r} is not a number; correct it") from error


def read_view(path: Path) -> Array:
    """What a camera saw: an array (frames, points, 2) of pixels in .npy, NaN where nothing was seen."""
    try:
        found = read_array(path)
    except (OSError, ValueError) as error:
        raise CorpusError(f"{path}: cannot be read as an array ({error}); save it with numpy.save") from error
    if found.ndim != 3 or found.shape[2] != 2 or found.dtype.kind not in "fiu":
        raise CorpusError(f"{path}: must be an array of pixels of the shape (frames, points, 2)")
    return found.astype(np.float64)


def read_views(paths: Sequence[Path]) -> list[Array]:
    """The views of several cameras. Raises CorpusError when they do not have the same frames and points."""
    views = [read_view(path) for path in paths]
    first = views[0].shape[:2]
    for path, view in zip(paths, views, strict=True):
        if view.shape[:2] != first:
            raise CorpusError(
                f"{path}: has frames and points {view.shape[:2]}, but {paths[0]} has {first}; cut them alike"
            )
    return views


def _homogeneous(points: Array) -> Array:
    return np.concatenate([points, np.ones((len(points), 1))], axis=1)


def _normalizing(points: Array) -> Array:
    """The similarity that moves points to mean 0 and mean square size 1 for each axis (the same, 4.4.4)."""
    size = points.shape[1]
    centre = points.mean(axis=0)
    scale = np.sqrt(size / ((points - centre) ** 2).sum(axis=1).mean())
    found = np.eye(size + 1) * scale
    found[:size, size], found[size, size] = -scale * centre, 1
    return found
