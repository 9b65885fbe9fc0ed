"""Write the shipped head as a GLB file, with vertex colours, sparse shapes and a neck; see build_head.py."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from hair_cap import hair_cap
from numpy.typing import NDArray
from shirt import shirt

from phonanim.media.glb import glb_bytes

Array = NDArray[Any]

COPYRIGHT = "CC0 1.0; base mesh: MakeHuman community (MPFB2); face units: Mika Suominen"

# Linear base colour and roughness of each material.
MATERIALS = {
    "skin": ((0.60, 0.36, 0.26), 0.55),
    "tongue": ((0.48, 0.13, 0.13), 0.40),
    "teeth_u": ((0.56, 0.51, 0.43), 0.25),
    "teeth_l": ((0.56, 0.51, 0.43), 0.25),
    "eye_l": ((0.82, 0.80, 0.77), 0.12),
    "eye_r": ((0.82, 0.80, 0.77), 0.12),
    "hair": ((0.062, 0.034, 0.020), 0.50),
    "shirt": ((0.060, 0.095, 0.135), 0.85),
}

# The head turns about the upper neck, (x, y, z) metres; skin moves along from LOW to HIGH, metres up and, for
# the chin lies below where the neck begins, LEAN times as many ahead.
PIVOT = (0.0, 0.675, 0.030)
LOW, HIGH, LEAN = 0.585, 0.680, 0.55

NORMAL_TOLERANCE = 2e-3  # a tenth of a degree is not seen


@dataclass(frozen=True)
class Part:
    """One piece: (n, 3) points in metres, (t, 3) triangles, (n, 3) colour factors, (targets, n, 3) deltas."""

    points: Array
    triangles: Array
    colors: Array
    deltas: Array


def normals(points: Array, triangles: Array) -> Array:
    """Unit vertex normals, weighted by area: (..., n, 3) -> (..., n, 3)."""
    corners = points[..., triangles, :]
    faces = np.cross(corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :])
    sums = np.zeros_like(points)
    for corner in range(3):
        np.add.at(sums, (..., triangles[:, corner], slice(None)), faces)
    return sums / np.linalg.norm(sums, axis=-1, keepdims=True)


def turning(points: Array) -> Array:
    """How far points follow the head as it turns, (n,) 0 to 1."""
    height = points[:, 1] + LEAN * (points[:, 2] - PIVOT[2])
    share = np.clip((height - LOW) / (HIGH - LOW), 0, 1)
    return share**2 * (3 - 2 * share)


class Buffer:
    """The binary chunk as it grows: its buffer views, and the accessors into them.

    Every sparse accessor has views of its own: Godot reports an error for indices in a larger view.
    """

    VIEWS: ClassVar[dict[str, dict[str, int]]] = {
        "vectors": {"byteStride": 12, "target": 34962},
        "colors": {"byteStride": 4, "target": 34962},
        "indices": {"target": 34963},
        "matrices": {},
    }

    def __init__(self) -> None:
        self.bytes = dict.fromkeys(self.VIEWS, b"")
        self.pieces: list[bytes] = []
        self.accessors: list[dict[str, Any]] = []
        self.zeros: dict[int, int] = {}

    def put(self, view: str, values: Array) -> dict[str, int]:
        """Append an array, padded to four bytes, and say where it is."""
        offset = len(self.bytes[view])
        data = np.ascontiguousarray(values).tobytes()
        self.bytes[view] += data + b"\0" * (-len(data) % 4)
        return {"bufferView": list(self.VIEWS).index(view), "byteOffset": offset}

    def piece(self, values: Array) -> dict[str, int]:
        """An array in a view of its own."""
        self.pieces.append(np.ascontiguousarray(values).tobytes())
        return {"bufferView": len(self.VIEWS) + len(self.pieces) - 1}

    def accessor(self, **spec: object) -> int:
        """The number of a new accessor."""
        self.accessors.append(spec)
        return len(self.accessors) - 1

    def vectors(self, values: Array, bounds: bool) -> int:
        """Points or normals, (n, 3)."""
        values = values.astype("<f4")
        limits = {"min": values.min(0).tolist(), "max": values.max(0).tolist()} if bounds else {}
        place = self.put("vectors", values)
        return self.accessor(**place, componentType=5126, count=len(values), type="VEC3", **limits)

    def colors(self, values: Array) -> int:
        """Vertex colours, (n, 3) linear, in bytes and opaque."""
        rgba = np.column_stack([np.rint(values * 255), np.full(len(values), 255)]).astype("<u1")
        place = self.put("colors", rgba)
        return self.accessor(**place, componentType=5121, normalized=True, count=len(rgba), type="VEC4")

    def joints(self, share: Array) -> int:
        """Vertices are bound to the neck and, where their share (n,) of it is not 0, to the head."""
        bound = np.zeros((len(share), 4), "<u1")
        bound[:, 1] = np.rint(share * 255) > 0
        return self.accessor(**self.put("colors", bound), componentType=5121, count=len(bound), type="VEC4")

    def weights(self, share: Array) -> int:
        """How far vertices follow the head, (n,); the rest is the neck's."""
        whole = np.rint(share * 255)
        shares = np.stack([255 - whole, whole, 0 * whole, 0 * whole], axis=1).astype("<u1")
        place = self.put("colors", shares)
        return self.accessor(**place, componentType=5121, normalized=True, count=len(shares), type="VEC4")

    def matrices(self, values: Array) -> int:
        """Matrices, (n, 4, 4)."""
        columns = np.swapaxes(values, 1, 2).astype("<f4")
        return self.accessor(
            **self.put("matrices", columns), componentType=5126, count=len(values), type="MAT4"
        )

    def triangles(self, values: Array) -> int:
        """Indices, (t, 3)."""
        flat = values.astype("<u2").ravel()
        return self.accessor(**self.put("indices", flat), componentType=5123, count=len(flat), type="SCALAR")

    def sparse(self, values: Array, rows: Array) -> int:
        """A morph attribute that is zero outside `rows`."""
        values = values.astype("<f4")
        limits = {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
        spec = {"componentType": 5126, "count": len(values), "type": "VEC3", **limits}
        if len(rows) == 0:
            if len(values) not in self.zeros:
                self.zeros[len(values)] = self.accessor(**spec)
            return self.zeros[len(values)]
        spec["sparse"] = {
            "count": len(rows),
            "indices": {**self.piece(rows.astype("<u2")), "componentType": 5123},
            "values": self.piece(values[rows]),
        }
        return self.accessor(**spec)

    def chunk(self) -> tuple[list[dict[str, Any]], bytes]:
        """The buffer views, and the binary chunk that holds them, each from a multiple of four bytes."""
        views, binary = [], b""
        kinds = [*self.VIEWS.values(), *({} for _ in self.pieces)]
        for data, kind in zip([*self.bytes.values(), *self.pieces], kinds, strict=True):
            views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), **kind})
            binary += data + b"\0" * (-len(data) % 4)
        return views, binary


def primitive(buffer: Buffer, name: str, part: Part, material: int) -> dict[str, Any]:
    """One part as a glTF primitive with its morph targets."""
    rest = normals(part.points, part.triangles)
    attributes = {"POSITION": buffer.vectors(part.points, True), "NORMAL": buffer.vectors(rest, False)}
    if not np.all(part.colors == 1):
        attributes["COLOR_0"] = buffer.colors(part.colors)
    share = turning(part.points) if name in ("skin", "shirt") else np.ones(len(part.points))
    attributes |= {"JOINTS_0": buffer.joints(share), "WEIGHTS_0": buffer.weights(share)}
    targets = []
    for delta in part.deltas:
        turned = normals(part.points + delta, part.triangles) - rest
        turned[np.abs(turned).max(axis=1) < NORMAL_TOLERANCE] = 0
        pair = {"POSITION": delta, "NORMAL": turned}
        targets.append({k: buffer.sparse(v, np.flatnonzero(np.abs(v).max(axis=1))) for k, v in pair.items()})
    indices = buffer.triangles(part.triangles)
    return {"attributes": attributes, "indices": indices, "material": material, "targets": targets}


def worn(buffer: Buffer, skin_: Part, first: int) -> dict[str, dict[str, Any]]:
    """Hair and shirt as glTF primitives without targets, by name; they turn with head and neck."""
    found = {}
    for number, (name, made) in enumerate({"hair": hair_cap, "shirt": shirt}.items(), first):
        points, triangles, colors = made(
            skin_.points, skin_.triangles, normals(skin_.points, skin_.triangles)
        )
        part = Part(points, triangles, colors, np.zeros((0, *points.shape)))
        one = primitive(buffer, name, part, number)
        found[name] = {key: value for key, value in one.items() if key != "targets"}
    return found


def assemble(parts: dict[str, Part], names: tuple[str, ...]) -> bytes:
    """The GLB file."""
    buffer = Buffer()
    primitives = [primitive(buffer, name, part, i) for i, (name, part) in enumerate(parts.items())]
    clothes = worn(buffer, parts["skin"], len(parts))
    inverse = np.tile(np.eye(4), (2, 1, 1))
    inverse[1, :3, 3] = -np.array(PIVOT)
    tree = {
        "asset": {"version": "2.0", "generator": "phonanim scripts/build_head.py", "copyright": COPYRIGHT},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 3, 4]}],
        "nodes": [
            {"name": "head", "mesh": 0, "skin": 0},
            {"name": "Neck", "children": [2]},
            {"name": "Head", "translation": list(PIVOT)},
            *({"name": name, "mesh": 1 + n, "skin": 0} for n, name in enumerate(clothes)),
        ],
        "skins": [{"joints": [1, 2], "skeleton": 1, "inverseBindMatrices": buffer.matrices(inverse)}],
        "meshes": [
            {
                "name": "head",
                "primitives": primitives,
                "weights": [0.0] * len(names),
                "extras": {"targetNames": list(names)},
            },
            *({"name": name, "primitives": [one]} for name, one in clothes.items()),
        ],
        "materials": [material(name) for name in (*parts, *clothes)],
        "accessors": buffer.accessors,
    }
    tree["bufferViews"], binary = buffer.chunk()
    tree["buffers"] = [{"byteLength": len(binary)}]
    return glb_bytes(tree, binary)


def material(name: str) -> dict[str, Any]:
    """A glTF material. The skin is seen from both sides: the inner mouth is its back."""
    color, roughness = MATERIALS[name]
    pbr = {"baseColorFactor": [*color, 1.0], "metallicFactor": 0.0, "roughnessFactor": roughness}
    return {"name": name, "pbrMetallicRoughness": pbr, "doubleSided": name in ("skin", "hair", "shirt")}
