"""DiffSinger: scripts (.ds), and transcriptions of data sets (CSV, Opencpop): phonemes and durations."""

from __future__ import annotations

import csv
from typing import Any

from phonanim.readers._rows import LONGEST_ROW, lines
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "DiffSinger scripts and transcriptions"
OPENCPOP = ("name", "text", "ph_seq", "note_seq", "note_dur", "ph_dur", "is_slur")
"""The fields of a line of Opencpop, between vertical bars."""


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with sequences of phonemes, or a table of utterances with them."""
    return bool(_table(source)) or (
        bool(_lines(source)) and all(isinstance(line, dict) and "ph_seq" in line for line in _lines(source))
    )


def read(source: AlignmentFile) -> Recording:
    """The phonemes. A label such as "zh/a" names its language before the slash."""
    if rows := _table(source):
        return _utterances(source, rows)
    phones: list[Interval] = []
    try:
        first = min(float(line.get("offset", 0.0)) for line in _lines(source))
        for line in _lines(source):
            phones += _phones(line, float(line.get("offset", 0.0)))
        end = max(one.end for one in phones)
    except DAMAGE as error:
        raise source.error(f"has a damaged line ({error}); export it with its durations") from error
    return Recording((Tier("phones", tuple(phones)),), first, end)


def _utterances(source: AlignmentFile, rows: list[dict[str, Any]]) -> Recording:
    """A tier for each utterance of a data set, whose name is the speaker."""
    try:
        tiers = [
            Tier("phones", tuple(_phones(row, 0.0)), number, str(row["name"]) if len(rows) > 1 else "")
            for number, row in enumerate(rows, 1)
        ]
        end = max(tier.intervals[-1].end for tier in tiers)
    except DAMAGE as error:
        raise source.error(f"has a damaged line ({error}); export it with its durations") from error
    return Recording(tuple(tiers), 0.0, end)


def _phones(line: dict[str, Any], time: float) -> list[Interval]:
    if not line.get("ph_dur"):
        raise ValueError("it has no ph_dur")
    names, lengths = _parts(line["ph_seq"]), _parts(line["ph_dur"])
    if len(names) != len(lengths):
        raise ValueError(f"{len(names)} phonemes and {len(lengths)} durations")
    phones: list[Interval] = []
    for name, length in zip(names, map(float, lengths), strict=True):
        phones.append(Interval(name.rpartition("/")[2] or name, time, time + length))
        time += length
    return phones


def _parts(value: Any) -> list[str]:
    """The parts of a list, or of a text with blanks between them."""
    return [str(part) for part in value] if isinstance(value, list) else str(value).split()


def _table(source: AlignmentFile) -> list[dict[str, Any]]:
    """The utterances of a table: CSV with a header, or the lines of Opencpop."""
    head = source.text[:LONGEST_ROW].partition("\n")[0]
    names = [name.strip() for name in head.split(",")]
    if {"name", "ph_seq", "ph_dur"} <= set(names):
        return list(csv.DictReader(lines(source)))
    if head.count("|") != len(OPENCPOP) - 1:
        return []
    rows = [row.split("|") for row in lines(source)]
    return [dict(zip(OPENCPOP, row, strict=True)) for row in rows if len(row) == len(OPENCPOP)]


def _lines(source: AlignmentFile) -> list[Any]:
    content = source.json
    return content if isinstance(content, list) else [content] if isinstance(content, dict) else []
