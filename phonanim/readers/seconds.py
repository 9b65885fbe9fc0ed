"""Rows of start, end and label in seconds: Audacity label tracks, Julius segmentation and similar files."""

from __future__ import annotations

import re

from phonanim.readers._rows import all_match, lines, split
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "label track in seconds"

# Audacity writes the decimal sign of its language, so that commas may stand in numbers but not between them.
_POINT = r"-?\d+\.\d*"
_ROW = re.compile(rf"({_POINT})[\s,;]+({_POINT})[\s,;]*(.*)")
_COMMA_ROW = re.compile(r"(-?\d+,\d+)[\t ;]+(-?\d+,\d+)[\t ;]*(.*)")
_START = re.compile(r"-?\d+[.,]\d")


def recognizes(source: AlignmentFile) -> bool:
    """Whether all rows are two numbers with a decimal sign and a label."""
    if not _START.match(source.text.lstrip()):
        return False
    rows = _plain(source)
    return bool(all_match(rows, _ROW) or all_match(rows, _COMMA_ROW))


def read(source: AlignmentFile) -> Recording:
    """The one tier of the file."""
    rows = _plain(source)
    pattern = _COMMA_ROW if all_match(rows, _COMMA_ROW) else _ROW
    matches = split(rows, pattern)
    intervals = tuple(
        Interval(match[3].strip("\"' "), _number(match[1]), _number(match[2])) for match in matches
    )
    return Recording((Tier("labels", intervals),), 0.0, max(interval.end for interval in intervals))


def _plain(source: AlignmentFile) -> AlignmentFile:
    """The file without the rows that begin with a backslash: the frequencies of a selection in Audacity."""
    if "\\" not in source.text:
        return source
    kept = "\n".join(line for line in lines(source) if not line.startswith("\\"))
    return AlignmentFile(source.name, source.stem, kept.encode())


def _number(text: str) -> float:
    return float(text.replace(",", "."))
