"""Read a head without shapes from a file: OBJ, PLY, STL and OFF by trimesh.

A GLB is read by `character`, which keeps the shapes that trimesh drops. Each format has one reader.
"""

from __future__ import annotations

import re
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import read_bounded
from phonanim.errors import RigError
from phonanim.rig.character import GREY, load_bare_character
from phonanim.rig.geometry import import_trimesh, weld
from phonanim.rig.head import Head

Array = NDArray[np.float64]

MAX_BYTES = 1 << 28
MESHES = (".obj", ".ply", ".stl", ".off")
# trimesh reads the file unchanged: nothing is merged, sorted or loaded from other files.
IN_ORDER = {
    "process": False,
    "maintain_order": True,
    "split_objects": True,
    "split_groups": True,
    "group_material": False,
    "skip_materials": True,
}


def load_mesh(path: Path) -> Head:
    """Read a head without shapes: an OBJ, PLY, STL or OFF file, or all meshes of a GLB file.

    Raises RigError, and MissingExtraError where trimesh is needed and not installed.
    """
    if path.suffix.lower() not in MESHES:
        return load_bare_character(path)
    points, triangles, parts = read_mesh(path)
    return Head(points, triangles, parts, (), np.zeros((0, *points.shape)), np.full_like(points, GREY))


def read_mesh(path: Path) -> tuple[Array, NDArray[np.int64], dict[str, slice]]:
    """Read an OBJ, PLY, STL or OFF file with trimesh: vertices (n, 3), triangles (t, 3), rows of each part.

    Vertices keep the order of the file; those of an STL file, which repeats them, are merged. The objects and
    groups of an OBJ file are its parts. Raises RigError when the file is damaged or holds no mesh,
    MissingExtraError without trimesh.
    """
    kind = path.suffix.lower().removeprefix(".")
    load_scene = import_trimesh().load_scene
    try:
        data = read_bounded(path, MAX_BYTES)
        scene = load_scene(BytesIO(_plain_obj(data) if kind == "obj" else data), kind, **IN_ORDER)
    except OSError as error:
        raise RigError(f"{path}: cannot be read: {error.strerror}") from error
    except Exception as error:  # any error of a parser in damaged data
        reason = " ".join(str(error).split())
        article = "an" if kind == "obj" else "a"
        raise RigError(
            f"{path}: is damaged or not {article} {kind.upper()} file ({reason}); export it again"
        ) from error
    meshes = {name: mesh for name, mesh in scene.geometry.items() if len(getattr(mesh, "faces", ()))}
    if not meshes:
        raise RigError(f"{path}: holds no mesh; export the head with its faces")
    points = np.asarray(next(iter(meshes.values())).vertices, np.float64)
    triangles = {name: np.asarray(mesh.faces, np.int64) for name, mesh in meshes.items()}
    if not np.isfinite(points).all():
        raise RigError(f"{path}: holds positions that are not finite; export it again")
    if kind == "stl":
        kept, place = weld(points, triangles[next(iter(triangles))])
        points, triangles = points[kept], {name: place[faces] for name, faces in triangles.items()}
    named = sorted(triangles, key=lambda name: int(triangles[name].min()))
    return points, np.concatenate([triangles[name] for name in named]), _parts(triangles, named, len(points))


def _plain_obj(data: bytes) -> bytes:
    """An OBJ file without texture coordinates and normals, at which trimesh would split vertices."""
    return re.sub(rb"(?m)^f[ \t].*$", lambda line: re.sub(rb"/\S*", b"", line[0]), data)


def _parts(triangles: dict[str, NDArray[np.int64]], named: list[str], count: int) -> dict[str, slice]:
    """The rows of each part, from its first vertex to that of the next; one part where they overlap."""
    firsts = [int(triangles[name].min()) for name in named]
    lasts = [int(triangles[name].max()) for name in named]
    if any(last >= first for last, first in zip(lasts, firsts[1:], strict=False)):
        return {"mesh": slice(0, count)}
    starts = [0, *firsts[1:], count]
    return {name: slice(*span) for name, span in zip(named, pairwise(starts), strict=True)}
