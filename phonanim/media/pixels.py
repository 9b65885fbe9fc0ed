"""Pictures as arrays of sRGB bytes: text drawing and PNG files."""

from __future__ import annotations

import struct
import zlib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import atomic_path
from phonanim.core.lexicon import LEXICON

Image = NDArray[np.uint8]
Color = tuple[int, int, int]

PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
TRUECOLOR = 2
UNKNOWN = ord("?")


def write_png(image: Image, path: Path) -> None:
    """Write a picture, (height, width, 3). The same picture gives the same bytes. Raises OutputError."""
    with atomic_path(path) as partial:
        partial.write_bytes(png_bytes(image))


def png_bytes(image: Image) -> bytes:
    """The bytes of a PNG file; a row is stored as its difference from the row above (ISO 15948, filter 2)."""
    height, width = image.shape[:2]
    rows = image.reshape(height, -1)
    differences = np.diff(rows, axis=0, prepend=np.zeros_like(rows[:1]))
    filtered = np.hstack([np.full((height, 1), 2, np.uint8), differences])
    header = struct.pack(">IIBBBBB", width, height, 8, TRUECOLOR, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b""))
    return PNG_MAGIC + b"".join(_chunk(kind, data) for kind, data in chunks)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def draw_text(
    image: Image, text: str, x: float, y: float, color: Color, face: str = "small", align: float = 0.0
) -> None:
    """Draw text on a picture in place, with the top of the line at row `y`.

    `align` is the share of the text to the left of column `x`: 0, 0.5 or 1. `face` is "small" or "large".
    Text outside the picture is cut off.
    """
    letters, ink, _ = _face(face)
    at = round(x - align * text_width(text, face))
    for character in text:
        start, width, shift, advance = letters.get(ord(character), letters[UNKNOWN])
        _blend(image, ink[:, start : start + width], at + shift, round(y), color)
        at += advance


def text_width(text: str, face: str = "small") -> int:
    """Width of a text in columns."""
    letters = _face(face)[0]
    return sum(letters.get(ord(character), letters[UNKNOWN])[3] for character in text)


def shortened(text: str, width: int, face: str = "small") -> str:
    """The text, cut with an ellipsis when it is wider than `width` columns."""
    if text_width(text, face) <= width:
        return text
    while text and text_width(text + "…", face) > width:
        text = text[:-1]
    return text + "…"


def fill(image: Image, x: float, y: float, width: float, height: float, color: Color) -> None:
    """Fill a rectangle in place."""
    rows = slice(max(0, round(y)), max(0, round(y + height)))
    image[rows, max(0, round(x)) : max(0, round(x + width))] = color


def paste(image: Image, piece: Image, x: int, y: int) -> None:
    """Copy a picture onto another in place."""
    image[y : y + piece.shape[0], x : x + piece.shape[1]] = piece


def _blend(image: Image, ink: Image, x: int, y: int, color: Color) -> None:
    """Blend a colour into a picture where there is ink, (rows, columns) 0 to 255."""
    top, left = max(0, -y), max(0, -x)
    spot = image[max(0, y) : max(0, y + ink.shape[0]), max(0, x) : max(0, x + ink.shape[1])]
    amount = ink[top : top + spot.shape[0], left : left + spot.shape[1], None] / 255
    spot[:] = np.rint(spot + amount * (np.array(color) - spot))


@cache
def _face(name: str) -> tuple[dict[int, Any], Image, int]:
    """Letters by code (first column, columns, shift, advance), their ink, and the rows above the line."""
    with np.load(LEXICON / "glyphs" / f"{name}.npz") as archive:
        letters = {int(code): tuple(map(int, rest)) for code, *rest in archive["letters"]}
        return letters, archive["ink"], int(archive["ascent"])
