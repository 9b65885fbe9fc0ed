"""A moving mesh as binary glTF: morph targets are directions in which it moves, their weights the motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.media.glb import glb_bytes

Array = NDArray[np.float64]
FLOAT, UNSIGNED, ARRAY, ELEMENTS = 5126, 5125, 34962, 34963
SKIN = [0.80, 0.62, 0.53, 1.0]


def mesh_glb(
    rest: Array,
    triangles: NDArray[np.int64],
    targets: NDArray[np.floating],
    weights: NDArray[np.floating],
    fps: float,
    name: str,
) -> bytes:
    """The bytes of a GLB: `rest` (vertices, 3) m, `targets` (k, vertices, 3) m, `weights` (frames, k)."""
    pieces: list[bytes] = []
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []

    def add(values: NDArray[Any], kind: str, target: int | None = None) -> int:
        data = values.tobytes()
        view = {"buffer": 0, "byteOffset": sum(map(len, pieces)), "byteLength": len(data)}
        views.append(view | ({"target": target} if target else {}))
        pieces.append(data + b"\0" * (-len(data) % 4))
        flat = values.reshape(len(values), -1)
        component = UNSIGNED if values.dtype.kind == "u" else FLOAT
        accessors.append(
            {
                "bufferView": len(views) - 1,
                "componentType": component,
                "count": len(values),
                "type": kind,
                "min": flat.min(axis=0).tolist(),
                "max": flat.max(axis=0).tolist(),
            }
        )
        return len(accessors) - 1

    primitive = {
        "attributes": {
            "POSITION": add(rest.astype("<f4"), "VEC3", ARRAY),
            "NORMAL": add(vertex_normals(rest, triangles).astype("<f4"), "VEC3", ARRAY),
        },
        "indices": add(triangles.astype("<u4").ravel(), "SCALAR", ELEMENTS),
        "targets": [{"POSITION": add(one.astype("<f4"), "VEC3", ARRAY)} for one in targets],
        "material": 0,
    }
    sampler = {
        "input": add((np.arange(len(weights)) / fps).astype("<f4"), "SCALAR"),
        "output": add(weights.astype("<f4").ravel(), "SCALAR"),
        "interpolation": "LINEAR",
    }
    names = [f"motion{number + 1}" for number in range(len(targets))]
    mesh = {"name": name, "primitives": [primitive], "weights": [0.0] * len(targets)}
    tree = {
        "asset": {"version": "2.0", "generator": "phonanim"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": name}],
        "meshes": [mesh | {"extras": {"targetNames": names}}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": SKIN, "metallicFactor": 0.0}, "doubleSided": True}
        ],
        "animations": [
            {
                "name": name,
                "samplers": [sampler],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
            }
        ],
        "bufferViews": views,
        "accessors": accessors,
        "buffers": [{"byteLength": sum(map(len, pieces))}],
    }
    return glb_bytes(tree, pieces)


def vertex_normals(points: Array, triangles: NDArray[np.int64]) -> Array:
    """Unit normals of vertices, (vertices, 3); up where a vertex has no triangle."""
    sides = points[triangles]
    faces = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    normals = np.zeros_like(points)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], faces)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(lengths > 0, normals / np.maximum(lengths, 1e-30), [0.0, 1.0, 0.0])
