"""Rows of times in seconds and a label: Audacity, WaveSurfer, Julius segmentation and similar files."""

from __future__ import annotations

import re
from typing import NamedTuple

from phonanim.readers._rows import all_match, from_ends, from_starts, lines, match_row, split
from phonanim.readers._words import SPREAD, are_lines, spread_lines, word_recording
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile
from phonanim.speech.labels import is_silent

FORMAT = "label track in seconds"
LAST_LABEL = 0.1
"""Seconds of the last label where rows have no end."""

STARTS = "rows have one time each: it was read as the start of the label"
ENDS = "rows have one time each: it was read as the end of the label, because the first is silence"
LENGTHS = "the second time of a row was read as a length, because rows would overlap or end before they start"

# Audacity writes the decimal sign of its language, so that commas may stand in numbers but not between them.
_POINT = r"-?\d+(?:\.\d*)?"
_COMMA = r"-?\d+,\d+"
_START = re.compile(r"-?\d+[.,]?\d*[\s,;]|(?:\"[^\"\n]{1,1000}\"|\S{1,16})[\s,;]+-?\d")
_CUES = frozenset("ABCDEFGHX")  # of Rhubarb


class _Layout(NamedTuple):
    """The pattern of a row, and the groups of label, start and end; 0 for no end."""

    pattern: re.Pattern[str]
    label: int
    start: int
    end: int


_LAYOUTS = (
    _Layout(re.compile(rf"({_COMMA})[\t ;]+({_COMMA})[\t ;]*(.*)"), 3, 1, 2),
    _Layout(re.compile(rf"({_POINT})[\s,;]+({_POINT})(?:[\s,;]+(.*)|)"), 3, 1, 2),
    _Layout(re.compile(rf"(\"[^\"]{{1,1000}}\"|\S{{1,60}}?)[\s,;]+({_POINT})[\s,;]+({_POINT})"), 1, 2, 3),
    _Layout(re.compile(rf"({_POINT})[\s,;]+(?!{_POINT}(?:\s|$))(\S.*)"), 2, 1, 0),
)
"""The better one first: two times and a label, a label and two times, a time and a label."""


def recognizes(source: AlignmentFile) -> bool:
    """Whether the first rows are a label and one or two times, some with a decimal sign."""
    if not _START.match(source.text.lstrip()):
        return False
    rows = _plain(source)
    layout = _layout(rows)
    matches = all_match(rows, layout.pattern) if layout else []
    if layout is None or not matches:
        return False
    times = [match[group] for match in matches for group in (layout.start, layout.end or layout.start)]
    cues = not layout.end and all(match[layout.label] in _CUES for match in matches)
    return any("." in time or "," in time for time in times) and not cues


def read(source: AlignmentFile) -> Recording:
    """The one tier of the file; labels without an end last until the next one."""
    rows = _plain(source)
    layout = _layout(rows)
    assert layout is not None, "recognizes() was asked before"
    matches = split(rows, layout.pattern)
    labels = [(match[layout.label] or "").strip("\"' ") for match in matches]
    starts = [_number(match[layout.start]) for match in matches]
    ends = [_number(match[layout.end]) for match in matches] if layout.end else starts
    notes: tuple[str, ...] = ()
    if starts == ends and is_silent(labels[0]) and starts[0] > 0:
        notes, intervals = (ENDS,), from_ends(list(zip(ends, labels, strict=True)))
    elif starts == ends:
        notes = (STARTS,)
        intervals = from_starts(list(zip(starts, labels, strict=True)), starts[-1] + LAST_LABEL)
    else:
        if _are_lengths(starts, ends):
            notes, ends = (LENGTHS,), [start + length for start, length in zip(starts, ends, strict=True)]
        intervals = tuple(map(Interval, labels, starts, ends))
    end = max(interval.end for interval in intervals)
    if are_lines(labels):
        return word_recording(spread_lines(intervals), end, (*notes, SPREAD))
    return Recording((Tier("labels", intervals),), 0.0, end, notes)


def _layout(source: AlignmentFile) -> _Layout | None:
    """The layout that the first row is in."""
    rows = lines(source)[:1]
    return next((layout for layout in _LAYOUTS for row in rows if match_row(layout.pattern, row)), None)


def _are_lengths(starts: list[float], ends: list[float]) -> bool:
    """Whether the second times are lengths: as ends they come before their starts, as lengths they fit."""
    if all(end >= start for start, end in zip(starts, ends, strict=True)):
        return False
    following = starts[1:]
    last = [start + length for start, length in zip(starts, ends, strict=True)]
    return all(end <= after + 0.02 for end, after in zip(last, following, strict=False))


def _plain(source: AlignmentFile) -> AlignmentFile:
    """The file without the rows that begin with a backslash: the frequencies of a selection in Audacity."""
    if "\\" not in source.text:
        return source
    kept = "\n".join(line for line in lines(source) if not line.startswith("\\"))
    return AlignmentFile(source.name, source.stem, kept.encode())


def _number(text: str) -> float:
    return float(text.replace(",", "."))
