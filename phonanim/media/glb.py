"""Binary glTF: the JSON and the binary chunk of a GLB file, and its accessors as arrays."""

from __future__ import annotations

import json
import struct
import time
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE, DecodeError, parse_json
from phonanim.core.files import read_bounded
from phonanim.errors import RigError
from phonanim.media.gltf import COMPONENTS, MAX_PLACE, WIDTHS, check_tree
from phonanim.media.gltf_text import pack_gltf

MAGIC = 0x46546C67  # "glTF"
JSON_CHUNK = 0x4E4F534A
BINARY_CHUNK = 0x004E4942
COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")
MAX_BYTES = 1 << 30
"""Largest file that is read."""
KEPT_BYTES = 1 << 26
"""Largest file that is kept."""
SETTLED = 2_000_000_000  # nanoseconds after which a further change of a file gets another time, on any system

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Glb:
    """A GLB file in memory: `tree` is its JSON, `binary` its chunk, `source` its path for messages."""

    tree: dict[str, Any]
    binary: bytes
    source: str

    @cached_property
    def parents(self) -> dict[int, int]:
        """The parent of each node that has one."""
        nodes = enumerate(self.tree["nodes"])
        return {child: number for number, node in nodes for child in node.get("children", ())}

    def accessor(self, index: int) -> NDArray[Any]:
        """One accessor as (count, width), with sparse values filled in and normalized integers as float32.

        Raises RigError when the accessor reaches outside the file or is compressed.
        """
        spec = self.tree["accessors"][index]
        width, kind = WIDTHS[spec["type"]], np.dtype(COMPONENTS[spec["componentType"]])
        if "bufferView" not in spec and "sparse" not in spec:
            self.refuse_compressed()  # Draco leaves accessors empty, so they would read as zeros
        if "bufferView" in spec:
            values = self._view(spec, kind, spec["count"], width)
        else:
            values = np.zeros((spec["count"], width), kind)
        if "sparse" in spec:
            values = self._filled(values.copy(), spec["sparse"])
        return _normalized(values) if spec.get("normalized") else values

    def positions(self, index: int, count: int | None = None) -> Array:
        """Positions or position offsets of an accessor, (n, 3) metres. Raises RigError for other data.

        If `count` is given, n must be equal to it.
        """
        points = self.accessor(index).astype(np.float64)
        if points.shape != (count or len(points), 3) or len(points) == 0:
            raise RigError(f"{self.source}: accessors[{index}] holds no positions that fit; export it again")
        if not (np.abs(points) <= MAX_PLACE).all():
            raise RigError(
                f"{self.source}: holds positions that are not finite, or farther than {MAX_PLACE:g} m; "
                "export it again"
            )
        return points

    def faces(self, primitive: dict[str, Any], count: int) -> NDArray[np.int64]:
        """The triangles of a primitive of `count` points, (t, 3). Raises RigError for other primitives."""
        if primitive.get("mode", 4) != 4:
            raise RigError(f"{self.source}: holds a mesh that is not of triangles; export it with triangles")
        rows = self.accessor(primitive["indices"]) if "indices" in primitive else np.arange(count)[:, None]
        if rows.dtype.kind not in "iu" or rows.shape[1] != 1 or len(rows) % 3:
            raise RigError(f"{self.source}: holds a mesh without whole triangles; export it again")
        if len(rows) and not 0 <= int(rows.min()) <= int(rows.max()) < count:
            raise RigError(f"{self.source}: has a triangle with a missing corner; export it again")
        return rows.reshape(-1, 3).astype(np.int64)

    def refuse_compressed(self, also: Iterable[str] = ()) -> None:
        """Raise RigError, which says how to decompress, when meshes are compressed or `also` is used."""
        used = [name for name in COMPRESSED if name in (*self.tree.get("extensionsUsed", ()), *also)]
        if used:
            raise RigError(
                f"{self.source}: its meshes are compressed ({used[0]}); "
                "save an uncompressed copy with: npx @gltf-transform/cli copy IN.glb OUT.glb"
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
        if step < kind.itemsize * width:
            raise RigError(f"{self.source}: the items of an accessor overlap; export it again")
        if count and start + (count - 1) * step + kind.itemsize * width > len(self.binary):
            raise RigError(f"{self.source}: an accessor reaches past the end of the file; export it again")
        values: NDArray[Any] = np.ndarray((count, width), kind, self.binary, start, (step, kind.itemsize))
        return values


def read_glb(path: Path) -> Glb:
    """Read a GLB file, or a `.gltf` with the files beside it. Raises RigError when it is neither."""
    try:
        data = read_bounded(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RigError(f"{path}: cannot be read: {reason}") from error
    if path.suffix.lower() == ".gltf" and not data.startswith(b"glTF"):
        return _parse_gltf(data, path)
    return parse_glb(data, str(path))


def kept_glb(path: Path) -> Glb:
    """The same, read once for the many lines of a run that use it; its tree is shared, so nobody changes it.

    A file is read again when its size or time has changed, or has changed just now, and when it is large or
    names others. Raises RigError as `read_glb` does.
    """
    try:
        found = path.stat()
    except OSError:
        return read_glb(path)
    settled = time.time_ns() - found.st_mtime_ns > SETTLED
    if not settled or found.st_size > KEPT_BYTES or path.suffix.lower() == ".gltf":
        return read_glb(path)
    return _kept(path, found.st_size, found.st_mtime_ns)


@lru_cache(maxsize=2)
def _kept(path: Path, size: int, changed: int) -> Glb:
    return read_glb(path)


def parse_glb(data: bytes, source: str) -> Glb:
    """The two chunks of a GLB file's bytes. Raises RigError when they are damaged."""
    if len(data) < 20 or struct.unpack_from("<II", data) != (MAGIC, 2):
        raise RigError(f"{source}: is not a binary glTF 2.0 file; export the character as .glb")
    chunks: dict[int, bytes] = {}
    at = 12
    while at + 8 <= len(data):
        length, kind = struct.unpack_from("<II", data, at)
        chunks.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    if at != len(data):
        raise RigError(
            f"{source}: is truncated or padded ({len(data)} bytes, {at} expected); export it again"
        )
    try:
        tree = parse_json(chunks[JSON_CHUNK])
    except (KeyError, ValueError) as error:
        raise RigError(f"{source}: has no readable JSON chunk; export it again") from error
    try:
        check_tree(tree, len(data))
    except DecodeError as error:
        raise RigError(f"{source}: is damaged: {error}; export it again") from error
    return Glb(tree, chunks.get(BINARY_CHUNK, b""), source)


def _parse_gltf(data: bytes, path: Path) -> Glb:
    """A `.gltf` as if it were packed. Raises RigError when it, or a file that it names, cannot be used."""
    try:
        tree, binary = pack_gltf(parse_json(data), path.parent, MAX_BYTES)
        check_tree(tree, len(data) + len(binary))
    except OSError as error:
        raise RigError(f"{path}: its file {error.filename} cannot be read: {error.strerror}") from error
    except DAMAGE as error:
        raise RigError(f"{path}: is damaged: {error}; export it again") from error
    return Glb(tree, binary, str(path))


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


def node_transform(glb: Glb, node: int) -> Array:
    """The transform of a node and of those above it, (4, 4)."""
    nodes = glb.tree["nodes"]
    matrix = _local(nodes[node])
    while node in glb.parents:  # `check_tree` ensures that there is no cycle
        node = glb.parents[node]
        matrix = _local(nodes[node]) @ matrix
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
    if values.dtype.kind == "f":
        return values
    largest = np.float32(np.iinfo(values.dtype).max)
    fractions: NDArray[np.float32] = np.maximum(values.astype(np.float32) / largest, np.float32(-1))
    return fractions
