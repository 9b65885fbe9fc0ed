"""One file per alignment format. Each has `recognizes(file)`, which looks at the content alone,
and `read(file)`, which returns every tier that the file holds.
"""

from __future__ import annotations

from itertools import chain
from typing import Protocol, cast

from phonanim.core.plugins import Registry
from phonanim.errors import AlignmentError
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

READERS = Registry("phonanim.readers", needs=("FORMAT", "recognizes", "read"))
COMMONEST = "textgrid"  # is tried first: the other readers then need not be imported


class Reader(Protocol):
    """What a module of this folder, or a plugin of the group `phonanim.readers`, offers."""

    FORMAT: str  # the format in a few words, for people

    def recognizes(self, source: AlignmentFile) -> bool:
        """Whether the content is of this format."""

    def read(self, source: AlignmentFile) -> Recording:
        """Every tier of the file. Raises AlignmentError where the content is damaged."""


def reader_names() -> tuple[str, ...]:
    """The formats, by the stem of their file."""
    return READERS.names()


def load_reader(name: str) -> Reader:
    """The reader of one format. Raises AlignmentError when there is none, PluginError when it is broken."""
    found = READERS.find(name)
    if found is None:
        raise AlignmentError(f"there is no reader {name!r}; there are {', '.join(reader_names())}")
    return cast("Reader", found)


def find_reader(source: AlignmentFile) -> Reader:
    """The reader that recognizes the content. Raises AlignmentError when none does."""
    for reader in map(load_reader, chain([COMMONEST], READERS.search())):
        if reader.recognizes(source):
            return reader
    names = sorted(reader_names(), key=lambda name: name != COMMONEST)
    formats = ", ".join(load_reader(name).FORMAT for name in names)
    kind = "no alignment in a known format" if source.text else "a binary file"
    raise source.error(f"is {kind}; what can be read: {formats}")
