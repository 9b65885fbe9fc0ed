"""Rows: text files with one label per line, as many aligners write them."""

from __future__ import annotations

import re
from collections.abc import Sequence

from phonanim.speech.alignment import Interval
from phonanim.speech.alignment_file import AlignmentFile, quote_label

ROWS_LOOKED_AT = 50
"""A format is recognized by the first rows of a file; a damaged row further down is an error of `read`."""

LONGEST_ROW = 4000
"""Characters; labels with their whole context have some hundred."""

FEWEST_TICKS = 40_000
"""Mean ticks of 100 ns in a label (4 ms); more than the samples in one. Separates HTK times from samples."""


def lines(source: AlignmentFile) -> list[str]:
    """The lines that are not empty, stripped."""
    return list(source.lines)


def match_row(pattern: re.Pattern[str], line: str) -> re.Match[str] | None:
    """The match of a row; a line that is longer than any row is none, and costs no time to find that out."""
    return pattern.fullmatch(line) if len(line) <= LONGEST_ROW else None


def all_match(source: AlignmentFile, pattern: re.Pattern[str]) -> list[re.Match[str]]:
    """The matches of the first rows; empty if one of them does not match."""
    found = [match_row(pattern, line) for line in source.lines[:ROWS_LOOKED_AT]]
    matches = [match for match in found if match]
    return matches if len(matches) == len(found) else []


def split(
    source: AlignmentFile, pattern: re.Pattern[str], text: list[str] | None = None
) -> list[re.Match[str]]:
    """The matches of all rows. Raises AlignmentError, which names the first row that does not match."""
    matches = []
    for number, line in enumerate(lines(source) if text is None else text, 1):
        match = match_row(pattern, line)
        if not match:
            raise source.error(f'row {number} "{quote_label(line)}" is damaged; correct it')
        matches.append(match)
    return matches


def mean_span(matches: Sequence[re.Match[str]]) -> float:
    """Mean difference of the first two columns."""
    return sum(float(match[2]) - float(match[1]) for match in matches) / len(matches)


def from_ends(ends: Sequence[tuple[float, str]]) -> tuple[Interval, ...]:
    """Intervals with known ends only: each begins where the one before it ended."""
    starts = [0.0, *(end for end, _ in ends)]
    return tuple(Interval(label, start, end) for start, (end, label) in zip(starts, ends, strict=False))


def from_starts(starts: Sequence[tuple[float, str]], end: float) -> tuple[Interval, ...]:
    """Intervals with known starts only: each ends where the next one begins."""
    ends = [*(start for start, _ in starts[1:]), end]
    return tuple(Interval(label, start, last) for (start, label), last in zip(starts, ends, strict=True))
