"""Write meshes: OBJ, and heads with morph targets as GLB."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import atomic_path, write_text
from phonanim.media.glb import glb_bytes
from phonanim.rig.geometry import vertex_normals
from phonanim.rig.head import Head

Array = NDArray[np.float64]

FLOAT, UNSIGNED = 5126, 5125
STILL = 1e-7  # metres: a vertex that moves less in a shape is not stored with it


def write_obj(path: Path, vertices: Array, triangles: NDArray[np.int64]) -> None:
    """Write an OBJ file atomically."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    write_text(path, "\n".join(lines) + "\n")


def write_head(path: Path, head: Head) -> None:
    """Write a head as a GLB with its shapes as named morph targets, atomically."""
    with atomic_path(path) as partial:
        partial.write_bytes(head_bytes(head))


def head_bytes(head: Head, painted: bool = False) -> bytes:
    """The bytes of a GLB: one mesh, a primitive per part, the shapes as sparse morph targets.

    A `painted` head has its colours at the points, on rough surfaces that are seen from both sides.
    """
    chunk = Chunk()
    names = list(head.parts)
    primitives = [chunk.primitive(head, head.parts[name], number) for number, name in enumerate(names)]
    if painted:
        normals = vertex_normals(head.vertices, head.triangles)
        normals[np.linalg.norm(normals, axis=1) < 0.5] = (0, 0, 1)  # points of no triangle
        for name, primitive in zip(names, primitives, strict=True):
            rows = head.parts[name]
            primitive["attributes"] |= {
                "NORMAL": chunk.vectors(normals[rows]),
                "COLOR_0": chunk.vectors(head.colors[rows].clip(0, 1)),
            }
    surface = {"doubleSided": True, "pbrMetallicRoughness": {"metallicFactor": 0.0}} if painted else {}
    tree = {
        "asset": {"version": "2.0", "generator": "phonanim"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "head", "mesh": 0}],
        "meshes": [{"name": "head", "primitives": primitives, "extras": {"targetNames": list(head.targets)}}],
        "materials": [{"name": name, **surface} for name in names],
        "accessors": chunk.accessors,
        "bufferViews": chunk.views,
        "buffers": [{"byteLength": len(chunk.data)}],
    }
    return glb_bytes(tree, bytes(chunk.data))


class Chunk:
    """The binary chunk of a GLB under construction, with its accessors and views."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def view(self, values: NDArray[Any]) -> int:
        """Append an array; return the number of its view."""
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes})
        self.data += values.tobytes()
        return len(self.views) - 1

    def accessor(self, **spec: Any) -> int:
        """Add an accessor; return its number."""
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

    def vectors(self, values: Array) -> int:
        """Normals or colours of points, (n, 3)."""
        view = self.view(values.astype("<f4"))
        return self.accessor(bufferView=view, componentType=FLOAT, count=len(values), type="VEC3")

    def target(self, delta: NDArray[np.float32], kind: dict[str, Any]) -> int:
        """The motion of a shape, stored only for the vertices that it moves."""
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
