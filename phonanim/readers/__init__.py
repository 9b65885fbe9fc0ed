"""One file per alignment format. Each has `recognizes(file)`, which checks the content alone,
and `read(file)`, which returns every tier of the file.
"""

from __future__ import annotations

import re
from itertools import chain
from typing import Protocol, cast

from phonanim.core.plugins import Registry
from phonanim.errors import AlignmentError
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile, TooManyWordsError

READERS = Registry("phonanim.readers", needs=("FORMAT", "recognizes", "read"))
LINES = (
    *(".srt", ".vtt", ".smi", ".sub", ".sbv", ".ass", ".ssa", ".lrc", ".ttml", ".dfxp", ".xml", ".json"),
    *(".tsv", ".csv"),
)
"""Suffixes of files that may give times to lines of text alone."""

EDITS = "which places clips, not words or sounds; export subtitles, or align the recording"
NOT_READ = (
    (re.compile(r"<(?:fcpxml|xmeml)\b"), f"is a timeline in XML, {EDITS}"),
    (re.compile(r"\ATITLE:.*\n(?:\s*FCM:|\d{3})"), f"is an edit list (EDL), {EDITS}"),
    (re.compile(r"\ASESSION NAME:"), f"is a session of Pro Tools, {EDITS}"),
)
"""Files that have no speech with times: what they begin with, and what a message says."""

COMMONEST = "textgrid"  # is tried first, so that the other readers are usually not imported


class Reader(Protocol):
    """What a module of this folder, or a plugin of the group `phonanim.readers`, offers."""

    FORMAT: str  # the format in a few words, for messages

    def recognizes(self, source: AlignmentFile) -> bool:
        """Whether the content is of this format."""

    def read(self, source: AlignmentFile) -> Recording:
        """Every tier of the file. Raises AlignmentError when the content is damaged."""


def reader_names() -> tuple[str, ...]:
    """The formats: the stems of this folder's files, and the plugins."""
    return READERS.names()


def load_reader(name: str) -> Reader:
    """The reader of one format. Raises AlignmentError if there is none, PluginError for a broken plugin."""
    found = READERS.find(name)
    if found is None:
        raise AlignmentError(f"there is no reader {name!r}; there are {', '.join(reader_names())}")
    return cast("Reader", found)


def find_reader(source: AlignmentFile) -> Reader:
    """The reader that recognizes the content. Raises AlignmentError when no reader does."""
    last: list[Reader] = []
    for reader in map(load_reader, chain([COMMONEST], READERS.search())):
        if getattr(reader, "GUESSES", False):
            last.append(reader)
        elif reader.recognizes(source):
            return reader
    for reader in last:
        if reader.recognizes(source):
            return reader
    refused = next((told for pattern, told in NOT_READ if pattern.search(source.text[:4000])), "")
    if refused:
        raise source.error(refused)
    kind = "not an alignment in a known format" if source.text else "a binary file of an unknown format"
    known = f"{load_reader(COMMONEST).FORMAT} and {len(reader_names()) - 1} others, listed by `phonanim info`"
    raise source.error(f"is {kind}; readable formats: {known}; `phonanim align` makes one")


def read_recording(source: AlignmentFile) -> Recording:
    """Every tier of a file, by the reader that recognizes it. Raises AlignmentError."""
    try:
        return find_reader(source).read(source)
    except TooManyWordsError as error:
        raise source.error(f"{error}; split the recording") from error
