"""Binary glTF: the JSON and the one binary chunk of a GLB file, and its accessors as arrays."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import RigError

MAGIC = 0x46546C67  # "glTF"
JSON_CHUNK = 0x4E4F534A
BINARY_CHUNK = 0x004E4942
COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Glb:
    """A GLB file in memory: `tree` is its JSON, `binary` its chunk, `source` its path for messages."""

    tree: dict[str, Any]
    binary: bytes
    source: str

    def accessor(self, index: int) -> NDArray[Any]:
        """One accessor as (count, width), sparse ones filled in, normalized integers as float32.

        Raises RigError when the accessor reaches outside the file or is compressed.
        """
        spec = self.tree["accessors"][index]
        width, kind = WIDTHS[spec["type"]], np.dtype(COMPONENTS[spec["componentType"]])
        if "bufferView" not in spec and "sparse" not in spec:
            self.refuse_compressed()  # Draco leaves accessors empty, which would read as noughts
        if "bufferView" in spec:
            values = self._view(spec, kind, spec["count"], width)
        else:
            values = np.zeros((spec["count"], width), kind)
        if "sparse" in spec:
            values = self._filled(values.copy(), spec["sparse"])
        return _normalized(values) if spec.get("normalized") else values

    def refuse_compressed(self, also: Iterable[str] = ()) -> None:
        """Raise RigError, which says how to decompress, when meshes (or what uses `also`) are compressed."""
        used = [name for name in COMPRESSED if name in (*self.tree.get("extensionsUsed", ()), *also)]
        if used:
            raise RigError(
                f"{self.source}: its meshes are compressed ({used[0]}); "
                "write it plain with: npx @gltf-transform/cli copy IN.glb OUT.glb"
            )

    def _filled(self, values: NDArray[Any], sparse: dict[str, Any]) -> NDArray[Any]:
        kind = np.dtype(COMPONENTS[sparse["indices"]["componentType"]])
        places = self._view(sparse["indices"], kind, sparse["count"], 1)[:, 0]
        if len(places) and int(places.max()) >= len(values):
            raise RigError(f"{self.source}: a sparse accessor points past its end; export the file again")
        values[places] = self._view(sparse["values"], values.dtype, sparse["count"], values.shape[1])
        return values

    def _view(self, spec: dict[str, Any], kind: np.dtype[Any], count: int, width: int) -> NDArray[Any]:
        """(count, width) items of a buffer view, which may be interleaved."""
        view = self.tree["bufferViews"][spec["bufferView"]]
        if "extensions" in view:
            self.refuse_compressed(view["extensions"])
        if view.get("buffer", 0) != 0:
            raise RigError(
                f"{self.source}: its data are outside the file; "
                "pack it with: npx @gltf-transform/cli copy IN.glb OUT.glb"
            )
        start = view.get("byteOffset", 0) + spec.get("byteOffset", 0)
        step = view.get("byteStride") or kind.itemsize * width
        if start + (count - 1) * step + kind.itemsize * width > len(self.binary):
            raise RigError(f"{self.source}: an accessor reaches past the end of the file; export it again")
        values: NDArray[Any] = np.ndarray((count, width), kind, self.binary, start, (step, kind.itemsize))
        return values


def read_glb(path: Path) -> Glb:
    """Read a GLB file. Raises RigError when it cannot be read or is no binary glTF 2.0."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise RigError(f"{path}: cannot be read: {error.strerror}") from error
    return parse_glb(data, str(path))


def parse_glb(data: bytes, source: str) -> Glb:
    """The two chunks of a GLB file's bytes. Raises RigError when they are damaged."""
    if len(data) < 20 or struct.unpack_from("<II", data) != (MAGIC, 2):
        raise RigError(f"{source}: is no binary glTF 2.0 file; export the character as .glb")
    chunks: dict[int, bytes] = {}
    at = 12
    while at + 8 <= len(data):
        length, kind = struct.unpack_from("<II", data, at)
        chunks.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    if at != len(data):
        raise RigError(
            f"{source}: is cut short or padded ({len(data)} bytes, {at} expected); export it again"
        )
    try:
        tree = json.loads(chunks[JSON_CHUNK])
    except (KeyError, ValueError) as error:
        raise RigError(f"{source}: has no readable JSON chunk; export it again") from error
    return Glb(tree, chunks.get(BINARY_CHUNK, b""), source)


def glb_bytes(tree: dict[str, Any], binary: bytes | list[bytes]) -> bytes:
    """The bytes of a GLB file; `binary` may be given in pieces. The same input gives the same bytes."""
    pieces = [binary] if isinstance(binary, bytes) else binary
    text = json.dumps(tree, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    size = sum(map(len, pieces))
    padding = b"\0" * (-size % 4)
    total = 12 + 8 + len(text) + 8 + size + len(padding)
    header = struct.pack("<IIIII", MAGIC, 2, total, len(text), JSON_CHUNK)
    chunk = struct.pack("<II", size + len(padding), BINARY_CHUNK)
    return b"".join([header, text, chunk, *pieces, padding])


def world_transform(tree: dict[str, Any], node: int) -> Array:
    """The transform of a node, (4, 4); a skinned mesh stands where its skeleton puts it: none."""
    if "skin" in tree["nodes"][node]:
        return np.eye(4)
    parents = {child: i for i, entry in enumerate(tree["nodes"]) for child in entry.get("children", ())}
    matrix = _local(tree["nodes"][node])
    while node in parents:
        node = parents[node]
        matrix = _local(tree["nodes"][node]) @ matrix
    return matrix


def _local(node: dict[str, Any]) -> Array:
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * node.get("scale", (1.0, 1.0, 1.0))
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix


def _normalized(values: NDArray[Any]) -> NDArray[np.float32]:
    """Integers as fractions (glTF 2.0, section 3.11)."""
    largest = np.float32(np.iinfo(values.dtype).max)
    fractions: NDArray[np.float32] = np.maximum(values.astype(np.float32) / largest, np.float32(-1))
    return fractions
