"""One file per alignment format. Each has `recognizes(file)`, which looks at the content alone,
and `read(file)`, which returns every tier that the file holds.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module
from typing import Protocol, cast

from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile


class Reader(Protocol):
    """What a module of this folder offers."""

    FORMAT: str

    def recognizes(self, source: AlignmentFile) -> bool:
        """Whether the content is of this format."""

    def read(self, source: AlignmentFile) -> Recording:
        """Every tier of the file. Raises AlignmentError where the content is damaged."""


def reader_names() -> tuple[str, ...]:
    """The formats, by the stem of their file."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__) if module.name[0] != "_"))


def load_reader(name: str) -> Reader:
    """The reader of one format."""
    return cast("Reader", import_module(f"{__name__}.{name}"))


def find_reader(source: AlignmentFile) -> Reader:
    """The reader that recognizes the content. Raises AlignmentError when none does."""
    # TextGrid, the commonest, is tried first: the other readers then need not be imported.
    names = sorted(reader_names(), key=lambda name: name != "textgrid")
    for reader in map(load_reader, names):
        if reader.recognizes(source):
            return reader
    formats = ", ".join(load_reader(name).FORMAT for name in names)
    kind = "no alignment in a known format" if source.text else "a binary file"
    raise source.error(f"is {kind}; what can be read: {formats}")
