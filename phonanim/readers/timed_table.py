"""Tables with a header: start, end and a phoneme, a label or a text (CSV, TSV)."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator

from phonanim.readers._rows import LONGEST_ROW
from phonanim.readers._words import SPREAD, TimedWord, spread_text, word_recording
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile, quote_label

FORMAT = "table of start, end and label (CSV, TSV)"
UNITS = {
    **dict.fromkeys(
        ("start", "begin", "onset", "start_time", "start_s", "tmin", "xmin", "start_seconds"), 1.0
    ),
    **dict.fromkeys(("start_ms", "begin_ms", "onset_ms"), 1e-3),
}
LASTS = {
    **dict.fromkeys(("end", "stop", "offset", "end_time", "end_s", "tmax", "xmax", "end_seconds"), False),
    **dict.fromkeys(("end_ms", "stop_ms", "offset_ms"), False),
    **dict.fromkeys(("duration", "dur", "duration_s", "duration_ms", "length"), True),
}
PHONES = ("phoneme", "phone", "label", "segment", "symbol", "mark", "viseme")
WORDS = ("word", "text", "token")
COLUMNS_OF_OTHERS = {"type", "speaker"}  # of the Montreal Forced Aligner, which has a reader of its own


def recognizes(source: AlignmentFile) -> bool:
    """Whether the first line names a start, an end or a duration, and a label."""
    header = _header(source)
    return _places(header) is not None and not set(header) >= COLUMNS_OF_OTHERS


def read(source: AlignmentFile) -> Recording:
    """The one tier of the table. Whole numbers beside texts are milliseconds, as Whisper writes them."""
    header = _header(source)
    start, last, label = _places(header) or (0, 1, 2)
    try:
        rows = [(number, row) for number, row in enumerate(_rows(source), 1) if number > 1 and any(row)]
    except csv.Error as error:
        raise source.error(f"has a damaged row ({error}); export it again") from error
    is_text = header[label] in WORDS
    plain = (
        is_text and header[start] == "start" and all(row[start : start + 1][0].isdigit() for _, row in rows)
    )
    unit = 1e-3 if plain else UNITS[header[start]]
    found = []
    for number, row in rows:
        try:
            begin, end = (float(row[place].replace(",", ".")) * unit for place in (start, last))
            if not math.isfinite(begin + end):
                raise ValueError("a time is not a number")
            end = begin + end if LASTS[header[last]] else end
            found.append(Interval(row[label].strip(), begin, end))
        except DAMAGE as error:
            shown = quote_label(" ".join(row))
            raise source.error(f'row {number} "{shown}" is damaged; correct it') from error
    if not found:
        raise source.error("has no rows; export it again")
    if is_text:
        return _words(found, unit)
    return Recording((Tier("phones", tuple(found)),), 0.0, max(one.end for one in found), unit=unit)


def _words(found: list[Interval], unit: float) -> Recording:
    words: list[TimedWord] = []
    for one in found:
        words += spread_text(one.label, one.start, one.end)
    notes = (SPREAD,) if len(words) > len(found) else ()
    return word_recording(words, max(one.end for one in found), notes, unit)


def _header(source: AlignmentFile) -> list[str]:
    line = source.text.partition("\n")[0]
    if len(line) > LONGEST_ROW:
        return []
    first = next(csv.reader([line], delimiter=_separator(source)), [])
    return [name.strip().lower().replace(" ", "_") for name in first]


def _rows(source: AlignmentFile) -> Iterator[list[str]]:
    return csv.reader(source.text.splitlines(), delimiter=_separator(source))


def _separator(source: AlignmentFile) -> str:
    return max("\t;,", key=source.text.partition("\n")[0].count)


def _places(header: list[str]) -> tuple[int, int, int] | None:
    """The columns of start, end and label, None where one is missing."""
    starts = [n for n, name in enumerate(header) if name in UNITS]
    lasts = [n for n, name in enumerate(header) if name in LASTS]
    labels = [header.index(name) for name in (*PHONES, *WORDS) if name in header]
    return (starts[0], lasts[0], labels[0]) if starts and lasts and labels else None
