"""TIMIT phone and word files (.PHN, .WRD): first and last sample at 16 kHz, and a label."""

from __future__ import annotations

import re

from phonanim.readers._rows import FEWEST_TICKS, all_match, mean_span, split
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "TIMIT labels"
RATE = 16_000.0
"""Samples per second, the same for all of TIMIT."""

_ROW = re.compile(r"(\d+)\s+(\d+)\s+(\S+)")


def recognizes(source: AlignmentFile) -> bool:
    """Whether all rows are two whole numbers and a label, with numbers too close to count 100 ns."""
    rows = all_match(source, _ROW)
    return bool(rows) and mean_span(rows) < FEWEST_TICKS


def read(source: AlignmentFile) -> Recording:
    """The one tier of the file."""
    matches = split(source, _ROW)
    intervals = tuple(Interval(match[3], float(match[1]) / RATE, float(match[2]) / RATE) for match in matches)
    return Recording((Tier("labels", intervals),), 0.0, intervals[-1].end, unit=1 / RATE)
