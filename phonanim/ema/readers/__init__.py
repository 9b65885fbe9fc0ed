"""Readers of sensor files: one module per format, named after it.

Each module has `recognizes(path)`, which checks the file's name or first bytes, and `read(path)`, which
returns the sensors in mm with the axes of the file.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Protocol, cast

from phonanim.core.files import open_plain
from phonanim.ema.articulation import Articulation
from phonanim.errors import CorpusError


class Reader(Protocol):
    """What a module of this folder offers."""

    def recognizes(self, path: Path) -> bool:
        """Whether a file is of this format."""

    def read(self, path: Path) -> Articulation:
        """The sensors of a recording. Raises CorpusError."""


@cache
def reader_names() -> tuple[str, ...]:
    """The formats: the stems of this folder's files."""
    return tuple(sorted(path.stem for path in Path(__file__).parent.glob("[a-z]*.py")))


def read_articulation(path: Path) -> Articulation:
    """Read sensors in any of the formats. Raises CorpusError for a file in none of them."""
    for name in reader_names():
        reader = cast("Reader", import_module(f"{__name__}.{name}"))
        if reader.recognizes(path):
            return reader.read(path)
    raise CorpusError(f"{path}: is not a file of sensors; known formats are {', '.join(reader_names())}")


def first_bytes(path: Path, count: int) -> bytes:
    """The beginning of a file. Raises CorpusError when it cannot be read."""
    try:
        with open_plain(path) as stream:
            return stream.read(count)
    except (OSError, ValueError) as error:
        raise CorpusError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from error
