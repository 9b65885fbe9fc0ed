"""An alignment file as bytes, text or JSON, before a reader knows its format."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from phonanim.core.files import read_bounded
from phonanim.errors import AlignmentError
from phonanim.speech.json_values import parse_stream, parse_value, without_partial
from phonanim.speech.text_encoding import decode_text

MAX_BYTES = 64 << 20
"""Largest file that is read: two hours of speech are about 10 MB, so a larger file is of another kind."""

MOST_TABLES = 1_000_000
"""Tables of a JSON file: two hours of speech with every detail of its sounds have fewer."""

MAX_QUOTE = 40
"""Maximum number of characters that a message quotes from a file."""

DAMAGE = (KeyError, IndexError, TypeError, AttributeError, ValueError, ArithmeticError)
"""The exceptions that parsed data of the wrong structure raise."""


class TooManyWordsError(Exception):
    """More words than a recording has."""


@dataclass(frozen=True)
class AlignmentFile:
    """The content of a file, decoded once; `name` is its path for messages, `stem` its base name."""

    name: str
    stem: str
    data: bytes

    @cached_property
    def text(self) -> str:
        """The content as text with Unix line ends; empty when it is binary."""
        text = decode_text(self.data)
        return "" if "\0" in text else text.replace("\r\n", "\n").replace("\r", "\n")

    @cached_property
    def lines(self) -> tuple[str, ...]:
        """The lines that are not empty, stripped."""
        return tuple(line.strip() for line in self.text.splitlines() if line.strip())

    @cached_property
    def json(self) -> Any:
        """The content as parsed JSON; None when it is not one JSON value."""
        return parse_value(self.text)

    @cached_property
    def json_lines(self) -> list[Any]:
        """The JSON values of the file, without results that were not final; a file of one is a list of one.

        Empty when anything else is between them.
        """
        values = [self.json] if self.json is not None else parse_stream(self.text)
        return without_partial(values)

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
    if data.lstrip()[:1] in (b"{", b"[") and data.count(b"{") > MOST_TABLES:
        raise AlignmentError(f"{path}: has more than {MOST_TABLES:,} tables of JSON; split the recording")
    return AlignmentFile(str(path), path.stem, data)
