"""Meshes in and out: OBJ, PLY, STL and OFF read, OBJ written, and heads with morph targets as GLB."""

from __future__ import annotations

import re
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import atomic_path, write_text
from phonanim.errors import RigError
from phonanim.media.glb import glb_bytes
from phonanim.rig.geometry import import_trimesh, weld
from phonanim.rig.head import Head

Array = NDArray[np.float64]

FLOAT, UNSIGNED = 5126, 5125
MESHES = (".obj", ".ply", ".stl", ".off")
# trimesh reads as the file stands: nothing merged, sorted or fetched from beside it.
IN_ORDER = {
    "process": False,
    "maintain_order": True,
    "split_objects": True,
    "split_groups": True,
    "group_material": False,
    "skip_materials": True,
}
STILL = 1e-7  # metres: a vertex that moves less in a shape is not stored with it


def read_mesh(path: Path) -> tuple[Array, NDArray[np.int64], dict[str, slice]]:
    """Read an OBJ, PLY, STL or OFF file with trimesh: vertices (n, 3), triangles (t, 3), rows of each part.

    Vertices keep the order of the file; those of an STL file, which repeats them, are merged. The objects and
    groups of an OBJ file are its parts. Raises RigError when the file is damaged or holds no mesh,
    MissingExtraError without trimesh.
    """
    kind = path.suffix.lower().removeprefix(".")
    load_scene = import_trimesh().load_scene
    try:
        data = path.read_bytes()
        scene = load_scene(BytesIO(_plain_obj(data) if kind == "obj" else data), kind, **IN_ORDER)
    except OSError as error:
        raise RigError(f"{path}: cannot be read: {error.strerror}") from error
    except Exception as error:  # whatever a parser trips over in damaged data
        reason = " ".join(str(error).split())
        raise RigError(f"{path}: is damaged or no {kind.upper()} file ({reason}); export it again") from error
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
    """An OBJ file without texture coordinates and normals, by which trimesh would split vertices."""
    return re.sub(rb"(?m)^f[ \t].*$", lambda line: re.sub(rb"/\S*", b"", line[0]), data)


def _parts(triangles: dict[str, NDArray[np.int64]], named: list[str], count: int) -> dict[str, slice]:
    """The rows of each part, from its first vertex to that of the next; one part where they overlap."""
    firsts = [int(triangles[name].min()) for name in named]
    lasts = [int(triangles[name].max()) for name in named]
    if any(last >= first for last, first in zip(lasts, firsts[1:], strict=False)):
        return {"mesh": slice(0, count)}
    starts = [0, *firsts[1:], count]
    return {name: slice(*span) for name, span in zip(named, pairwise(starts), strict=True)}


def write_obj(path: Path, vertices: Array, triangles: NDArray[np.int64]) -> None:
    """Write an OBJ file, whole or not at all."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    write_text(path, "\n".join(lines) + "\n")


def write_head(path: Path, head: Head) -> None:
    """Write a head as a GLB with its shapes as named morph targets, whole or not at all."""
    with atomic_path(path) as partial:
        partial.write_bytes(head_bytes(head))


def head_bytes(head: Head) -> bytes:
    """The bytes of a GLB: one mesh, a primitive per part, the shapes as sparse morph targets."""
    chunk = Chunk()
    names = list(head.parts)
    primitives = [chunk.primitive(head, head.parts[name], number) for number, name in enumerate(names)]
    tree = {
        "asset": {"version": "2.0", "generator": "phonanim"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "head", "mesh": 0}],
        "meshes": [{"name": "head", "primitives": primitives, "extras": {"targetNames": list(head.targets)}}],
        "materials": [{"name": name} for name in names],
        "accessors": chunk.accessors,
        "bufferViews": chunk.views,
        "buffers": [{"byteLength": len(chunk.data)}],
    }
    return glb_bytes(tree, bytes(chunk.data))


class Chunk:
    """The binary chunk of a GLB as it grows, with its accessors and views."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def view(self, values: NDArray[Any]) -> int:
        """Append an array; the number of its view."""
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes})
        self.data += values.tobytes()
        return len(self.views) - 1

    def accessor(self, **spec: Any) -> int:
        """Add an accessor; its number."""
        self.accessors.append(spec)
        return len(self.accessors) - 1

    def primitive(self, head: Head, rows: slice, material: int) -> dict[str, Any]:
        """One part of a head with its shapes."""
        points = head.vertices[rows].astype("<f4")
        inside = ((head.triangles >= rows.start) & (head.triangles < rows.stop)).all(axis=1)
        faces = (head.triangles[inside] - rows.start).astype("<u4").ravel()
        limits = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
        kind = {"componentType": FLOAT, "count": len(points), "type": "VEC3"}
        place = self.accessor(bufferView=self.view(points), **kind, **limits)
        index = self.accessor(
            bufferView=self.view(faces), componentType=UNSIGNED, count=len(faces), type="SCALAR"
        )
        targets = [{"POSITION": self.target(delta[rows].astype("<f4"), kind)} for delta in head.deltas]
        return {"attributes": {"POSITION": place}, "indices": index, "material": material, "targets": targets}

    def target(self, delta: NDArray[np.float32], kind: dict[str, Any]) -> int:
        """What a shape moves, stored for the vertices that it moves alone."""
        moved = np.flatnonzero(np.abs(delta).max(axis=1) > STILL).astype("<u4")
        if len(moved) == 0:
            return self.accessor(**kind, min=[0.0] * 3, max=[0.0] * 3)
        kept = np.zeros_like(delta)
        kept[moved] = delta[moved]
        sparse = {
            "count": len(moved),
            "indices": {"bufferView": self.view(moved), "componentType": UNSIGNED},
            "values": {"bufferView": self.view(delta[moved])},
        }
        return self.accessor(
            **kind, min=kept.min(axis=0).tolist(), max=kept.max(axis=0).tolist(), sparse=sparse
        )
