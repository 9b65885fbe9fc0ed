"""An alignment file as bytes, text or JSON, before a reader knows its format."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from phonanim.core.decode import DecodeError, parse_json
from phonanim.core.files import read_bounded
from phonanim.errors import AlignmentError

MAX_BYTES = 64 << 20
"""Largest file that is read: two hours of speech are about 10 MB, so a larger file is of another kind."""

MAX_QUOTE = 40
"""Maximum number of characters that a message quotes from a file."""

DAMAGE = (KeyError, IndexError, TypeError, AttributeError, ValueError, ArithmeticError)
"""The exceptions that parsed data of the wrong structure raise."""


@dataclass(frozen=True)
class AlignmentFile:
    """The content of a file, decoded once; `name` is its path for messages, `stem` its base name."""

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
            return parse_json(self.text, numbers_only=False)
        except DecodeError:
            return None

    @cached_property
    def json_lines(self) -> list[Any]:
        """The JSON values of the file, one on each line; a file of one value is a list of one.

        Empty when any line is not JSON.
        """
        if self.json is not None:
            return [self.json]
        lines = [line for line in self.text.splitlines() if line.strip()]
        if not lines or not lines[0].lstrip().startswith("{"):
            return []
        try:
            return [parse_json(line, numbers_only=False) for line in lines]
        except DecodeError:
            return []

    def error(self, what: str) -> AlignmentError:
        """An error that names this file, in one line whatever the file contains."""
        return AlignmentError(f"{self.name}: {_printable(what)}")


def quote_label(text: str) -> str:
    """Text from a file, made short and printable so that one line can quote it."""
    flat = _printable(text)
    return flat if len(flat) <= MAX_QUOTE else flat[: MAX_QUOTE - 1] + "…"


def _printable(text: str) -> str:
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def open_alignment_file(path: Path) -> AlignmentFile:
    """The content of `path`. Raises AlignmentError: a folder, missing, unreadable, empty or too large."""
    if path.is_dir():
        raise AlignmentError(f"{path}: is a folder; name one alignment file in it")
    try:
        data = read_bounded(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise AlignmentError(f"{path}: cannot be read: {reason}") from error
    if not data.strip():
        raise AlignmentError(f"{path}: is empty; align the recording again")
    return AlignmentFile(str(path), path.stem, data)


def _decode(data: bytes) -> str:
    """Text in the encodings that Praat writes: UTF-16 with a byte-order mark, UTF-8, or (old) Latin-1."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")
