"""glTF as text (`.gltf`): its buffers and images, data URIs or files beside it, as one binary chunk."""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from phonanim.core.decode import DecodeError, decode_list, decode_table, decode_text
from phonanim.core.files import read_bounded

KINDS = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".webp": "image/webp"}
DATA = "data:application/octet-stream;base64,"


def pack_gltf(tree: Any, folder: Path, most: int) -> tuple[dict[str, Any], bytes]:
    """The JSON of a GLB and its binary chunk, of at most `most` bytes.

    Raises DecodeError for addresses other than of files in the folder, OSError for files that are not there.
    """
    tree = dict(decode_table(tree, "its JSON"))
    packed = _Packed(folder, most)
    starts = [packed.place(one)[0] for one in _tables(tree, "buffers")]
    views = [_moved(view, starts) for view in _tables(tree, "bufferViews")]
    images = []
    for image in _tables(tree, "images"):
        if "uri" in image:
            start, length = packed.place(image)
            views.append({"buffer": 0, "byteOffset": start, "byteLength": length})
            kept = {key: value for key, value in image.items() if key != "uri"}
            kind = {"mimeType": _kind(image["uri"])}
            images.append({**kind, **kept, "bufferView": len(views) - 1})
        else:
            images.append(image)
    buffers = [{"byteLength": packed.size}] if packed.pieces else []
    changes = {"buffers": buffers, "bufferViews": views, "images": images}
    return {**tree, **{key: value for key, value in changes.items() if value}}, b"".join(packed.pieces)


def data_uri(content: bytes) -> str:
    """Bytes as an address that holds them."""
    return DATA + base64.b64encode(content).decode()


def _tables(tree: dict[str, Any], name: str) -> list[dict[str, Any]]:
    listed = decode_list(tree.get(name, []), name)
    return [decode_table(one, f"{name}[{number}]") for number, one in enumerate(listed)]


@dataclass
class _Packed:
    """The binary chunk so far: what each address leads to is in it once, at a multiple of four."""

    folder: Path
    most: int
    pieces: list[bytes] = field(default_factory=list)
    places: dict[str, tuple[int, int]] = field(default_factory=dict)
    size: int = 0

    def place(self, entry: dict[str, Any]) -> tuple[int, int]:
        """Where the content of a buffer or an image begins, and its length. Raises DecodeError, OSError."""
        uri = decode_text(entry.get("uri"), "the uri of a buffer or an image")
        if uri not in self.places:
            content = _content(uri, self.folder, self.most)
            self.places[uri] = self.size, len(content)
            self.pieces.append(content + b"\0" * (-len(content) % 4))
            self.size += len(self.pieces[-1])
            if self.size > self.most:
                raise DecodeError(f"its buffers and images have more than {self.most >> 20} MB")
        return self.places[uri]


def _moved(view: dict[str, Any], starts: list[int]) -> dict[str, Any]:
    """A buffer view in the one binary chunk."""
    if len(starts) > 1 and "extensions" in view:
        raise DecodeError("it has several buffers with compressed data")
    start = starts[view.get("buffer", 0)] + view.get("byteOffset", 0)
    return {**view, "buffer": 0, "byteOffset": start}


def _content(uri: str, folder: Path, most: int) -> bytes:
    """What the address of a buffer or an image leads to."""
    if uri.startswith("data:"):
        head, comma, text = uri.partition(",")
        if not comma or not head.endswith(";base64"):
            raise DecodeError("a data URI in it is not base64")
        try:
            return base64.b64decode(text, validate=True)
        except binascii.Error as error:
            raise DecodeError(f"a data URI in it is not base64: {error}") from error
    name = unquote(uri)
    parts = name.split("/")
    if any(part in ("", "..") for part in parts) or any(letter in name for letter in "\\:\0"):
        raise DecodeError(f"its file {name!r} is not in its folder")
    return read_bounded(folder / name, most)


def _kind(uri: str) -> str:
    if uri.startswith("data:"):
        return uri[5:].split(";")[0]
    return KINDS.get(Path(uri).suffix.lower(), "image/png")
