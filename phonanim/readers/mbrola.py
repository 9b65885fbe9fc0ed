"""Phonemes of MBROLA and eSpeak (.pho): a phoneme, its milliseconds, and pairs of place and pitch."""

from __future__ import annotations

import re

from phonanim.readers._rows import lines, match_row, split
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "MBROLA phonemes (.pho)"
MILLISECOND = 1e-3
SHORTEST = 5  # milliseconds of a phoneme on average; smaller numbers are seconds of another format

_NUMBER = r"\d+(?:\.\d*)?"
_ROW = re.compile(
    rf"([^\s\d;]\S*|\d[^\s\d.]\S*|[2369])\s+({_NUMBER})((?:[\s(,]+{_NUMBER}[\s,)]+{_NUMBER}[\s)]*)*)"
)


def recognizes(source: AlignmentFile) -> bool:
    """Whether all rows are a phoneme, a length and pairs of numbers; comments begin with a semicolon."""
    rows = _rows(source)
    matches = [match_row(_ROW, row) for row in rows[:50]]
    lengths = [float(match[2]) for match in matches if match]
    return len(rows) > 1 and len(lengths) == len(matches) and sum(lengths) >= SHORTEST * len(lengths)


def read(source: AlignmentFile) -> Recording:
    """The one tier of the file; "_" is silence."""
    phones: list[Interval] = []
    time = 0.0
    for match in split(source, _ROW, _rows(source)):
        last = time + float(match[2]) * MILLISECOND
        phones.append(Interval(match[1], time, last))
        time = last
    return Recording((Tier("phones", tuple(phones)),), 0.0, time, unit=MILLISECOND)


def _rows(source: AlignmentFile) -> list[str]:
    rows = (line for line in lines(source) if not line.startswith(";"))
    return [row for line in rows if (row := re.split(r"\s;", line)[0].rstrip()) != "#"]
