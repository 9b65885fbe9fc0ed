"""One file per alignment format. Each has `recognizes(source)`, which looks at the content alone,
and `read(source)`, which returns every tier that the file holds.
"""

from __future__ import annotations

import json
import pkgutil
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

from phonanim.errors import AlignmentError

if TYPE_CHECKING:
    from phonanim.speech.alignment import Recording

MAX_BYTES = 64 << 20
"""Largest file that is read: two hours of speech are about 10 MB; more is another kind of file."""


MAX_QUOTE = 40
"""Most characters that a message quotes from a file."""


DAMAGE = (KeyError, IndexError, TypeError, AttributeError, ValueError, ArithmeticError)
"""What taking the wrong shape or number out of parsed data raises."""


class Reader(Protocol):
    """What a module of this folder offers."""

    FORMAT: str

    def recognizes(self, source: Source) -> bool:
        """Whether the content is of this format."""

    def read(self, source: Source) -> Recording:
        """Every tier of the file. Raises AlignmentError where the content is damaged."""


@dataclass(frozen=True)
class Source:
    """The content of a file, decoded once; `name` is its path for messages, `stem` its bare name."""

    name: str
    stem: str
    data: bytes

    @cached_property
    def text(self) -> str:
        """The content as text with Unix line ends; empty when it is binary."""
        text = _decode(self.data)
        return "" if "\0" in text else text.replace("\r\n", "\n").replace("\r", "\n")

    @cached_property
    def json(self) -> Any:
        """The content as parsed JSON; None when it is not JSON."""
        if self.text.lstrip()[:1] not in ("{", "["):
            return None
        try:
            return json.loads(self.text)
        except (ValueError, RecursionError):
            return None

    def error(self, what: str) -> AlignmentError:
        """An error that names this file, in one line whatever the file put into it."""
        return AlignmentError(f"{self.name}: {_printable(what)}")


def brief(text: str) -> str:
    """What a file says, fit to be quoted in one line: short and printable."""
    flat = _printable(text)
    return flat if len(flat) <= MAX_QUOTE else flat[: MAX_QUOTE - 1] + "…"


def _printable(text: str) -> str:
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def open_source(path: Path) -> Source:
    """The content of `path`. Raises AlignmentError when it is a folder, absent, unreadable, empty or vast."""
    if path.is_dir():
        raise AlignmentError(f"{path}: is a folder; name one alignment file in it")
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise AlignmentError(f"{path}: has {size >> 20} MB; an alignment has at most {MAX_BYTES >> 20}")
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise AlignmentError(f"{path}: cannot be read: {reason}") from error
    if not data.strip():
        raise AlignmentError(f"{path}: is empty; align the recording again")
    return Source(str(path), path.stem, data)


def reader_names() -> tuple[str, ...]:
    """The formats, by the stem of their file."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def load_reader(name: str) -> Reader:
    """The reader of one format."""
    return cast("Reader", import_module(f"{__name__}.{name}"))


def find_reader(source: Source) -> Reader:
    """The reader that recognizes the content. Raises AlignmentError when none does."""
    # TextGrid, the commonest, is tried first: the other readers then need not be imported.
    names = sorted(reader_names(), key=lambda name: name != "textgrid")
    for reader in map(load_reader, names):
        if reader.recognizes(source):
            return reader
    formats = ", ".join(load_reader(name).FORMAT for name in names)
    kind = "no alignment in a known format" if source.text else "a binary file"
    raise source.error(f"is {kind}; what can be read: {formats}")


def _decode(data: bytes) -> str:
    """Text in the encodings that Praat writes: UTF-16 with a mark, UTF-8, or Latin-1 of old."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")
