"""Tables with a header: start, and end or duration, and a phoneme, a label or a text (CSV, TSV)."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator
from typing import NamedTuple

from phonanim.readers._columns import (
    LABELS,
    PHONES,
    TIERS,
    VISEMES,
    WORDS,
    Times,
    find_column,
    find_times,
    values_at,
)
from phonanim.readers._rows import LONGEST_ROW
from phonanim.readers._words import SPREAD, TimedWord, check_count, spread_text, word_recording
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile, quote_label

FORMAT = "table of start, end and label (CSV, TSV)"
SPEAKERS = ("speaker", "speakername", "speakerid", "character")
MFA = ["begin", "end", "label", "type", "speaker"]
"""The columns of the Montreal Forced Aligner, which has a reader of its own."""

_COMMENTS = re.compile(r"\A(?:\s*(?:#(?![,;\t])|//|sep=).*\n)+")
_TIME_CODE = re.compile(r"\s*\d{1,2}:\d\d:\d\d[:;]\d\d\s*")


class Columns(NamedTuple):
    """The columns of a table by name, "" where there is none."""

    times: Times
    label: str
    kind: str
    tier: str
    speaker: str


Row = tuple[str, str, Interval]  # tier, speaker and interval


def recognizes(source: AlignmentFile) -> bool:
    """Whether the first line names times and a label."""
    return _columns(source) is not None


def read(source: AlignmentFile) -> Recording:
    """The tiers of the table: those that it names, else one of phones, labels or words.

    Whole numbers beside texts are milliseconds, as Whisper writes them.
    """
    columns = _columns(source)
    assert columns is not None, "recognizes() was asked before"
    unit = _unit(source, columns)
    rows = [
        row
        for number, cells in enumerate(_rows(source), 2)
        if any(cells.values()) and (row := _row(source, columns, cells, unit, number))
    ]
    if not rows:
        raise source.error("has no rows; export it again")
    if columns.kind == "words" and not columns.tier:
        return _words(rows, unit)
    found: dict[tuple[str, str], list[Interval]] = {}
    for tier, speaker, interval in rows:
        found.setdefault((tier, speaker), []).append(interval)
    tiers = [
        Tier(tier or columns.kind, tuple(sorted(intervals, key=_begin)), n, speaker)
        for n, ((tier, speaker), intervals) in enumerate(found.items(), 1)
    ]
    return Recording(tuple(tiers), 0.0, max(interval.end for *_, interval in rows), unit=unit)


def _begin(interval: Interval) -> float:
    return interval.start


def _row(
    source: AlignmentFile, columns: Columns, cells: dict[str, str], unit: float, number: int
) -> Row | None:
    """A row; None for a marker, which has no end."""
    try:
        start, end = (time * unit for time in values_at(cells, columns.times))
        if math.isinf(start + end) or math.isnan(start):
            raise ValueError("a time is not a number")
    except DAMAGE as error:
        if code := next(filter(_TIME_CODE.fullmatch, cells.values()), ""):
            told = f"row {number} has a time code that counts frames ({code})"
            raise source.error(f"{told}; export times such as 00:00:01.250") from error
        shown = quote_label(" ".join(cells.values()))
        raise source.error(f'row {number} "{shown}" is damaged; correct it') from error
    if math.isnan(end):
        return None
    interval = Interval(cells[columns.label].strip(), start, end)
    return _cell(cells, columns.tier), _cell(cells, columns.speaker), interval


def _cell(cells: dict[str, str], name: str) -> str:
    return cells[name].strip() if name else ""


def _words(rows: list[Row], unit: float) -> Recording:
    words: list[TimedWord] = []
    for _, speaker, one in rows:
        words += spread_text(one.label, one.start, one.end, speaker)
        check_count(words)
    notes = (SPREAD,) if len(words) > len(rows) else ()
    return word_recording(words, max(one.end for *_, one in rows), notes, unit)


def _unit(source: AlignmentFile, columns: Columns) -> float:
    """Seconds of a number: as the name tells, else seconds, but for the whole numbers of Whisper."""
    if columns.times.unit is not None:
        return columns.times.unit
    starts = [cells.get(columns.times.start, "") for cells in _rows(source) if any(cells.values())]
    plain = columns.kind == "words" and columns.times.start.strip().lower() == "start"
    return 1e-3 if plain and starts and all(map(str.isdigit, starts)) else 1.0


def _columns(source: AlignmentFile) -> Columns | None:
    """The columns that hold times and labels; None where some are missing."""
    names = _header(source)
    plain = [name.strip().lower() for name in names]
    times = find_times(names)
    if times is None or plain == MFA or not (times.start and (times.end or times.length)):
        return None
    praat = "tmin" in plain  # its texts are labels of any tier
    for wanted, kind in ((PHONES, "phones"), (VISEMES, "phones"), (WORDS, "words"), (LABELS, "labels")):
        if label := find_column(names, wanted):
            tier = find_column([name for name in names if name != label], TIERS)
            kind = "labels" if praat else kind
            return Columns(times, label, kind, _names_tiers(source, tier), find_column(names, SPEAKERS))
    return None


def _names_tiers(source: AlignmentFile, name: str) -> str:
    """The column of tiers, if it names one of phones or of words."""
    from phonanim.speech.tiers import PHONE_NAMES, WORD_NAMES

    found = {cells[name].strip().lower() for cells in _rows(source)} if name else set()
    named = name.strip().lower() == "tier" and len(found) > 1
    return name if named or found & {*PHONE_NAMES, *WORD_NAMES} else ""


def _header(source: AlignmentFile) -> list[str]:
    line = _table(source).partition("\n")[0]
    if len(line) > LONGEST_ROW:
        return []
    return next(csv.reader([line], delimiter=_separator(source)), [])


def _rows(source: AlignmentFile) -> Iterator[dict[str, str]]:
    """The rows below the header by the names of its columns. Raises AlignmentError for a damaged one."""
    names = _header(source)
    try:
        for row in csv.reader(_table(source).splitlines()[1:], delimiter=_separator(source)):
            yield dict(zip(names, [*row, *[""] * len(names)], strict=False))
    except csv.Error as error:
        raise source.error(f"has a damaged row ({error}); export it again") from error


def _separator(source: AlignmentFile) -> str:
    return max("\t;,", key=_table(source).partition("\n")[0].count)


def _table(source: AlignmentFile) -> str:
    """The text from the header on, without comments before it."""
    found = _COMMENTS.match(source.text)
    return source.text[found.end() :] if found else source.text
