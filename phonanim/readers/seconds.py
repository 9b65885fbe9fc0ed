"""Rows of start, end and label in seconds: Audacity label tracks, Julius segmentation and similar files."""

from __future__ import annotations

import re

from phonanim.readers._rows import all_match, split
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "label track in seconds"

_NUMBER = r"-?\d+\.\d*"
_ROW = re.compile(rf"({_NUMBER})[\s,;]+({_NUMBER})[\s,;]*(.*)")


def recognizes(source: AlignmentFile) -> bool:
    """Whether all rows are two numbers with a decimal point and a label."""
    rows = all_match(source, _ROW)
    # Lines that begin with a backslash contain the frequencies of an Audacity selection.
    return bool(rows)


def read(source: AlignmentFile) -> Recording:
    """The one tier of the file."""
    matches = split(source, _ROW)
    intervals = tuple(Interval(match[3].strip("\"' "), float(match[1]), float(match[2])) for match in matches)
    return Recording((Tier("labels", intervals),), 0.0, max(interval.end for interval in intervals))
