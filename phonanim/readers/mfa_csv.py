"""CSV of the Montreal Forced Aligner: Begin, End, Label, Type, Speaker."""

from __future__ import annotations

import csv
from collections.abc import Iterator

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "MFA CSV"
COLUMNS = ("begin", "end", "label", "type", "speaker")


def recognizes(source: AlignmentFile) -> bool:
    """Whether the first line names these columns."""
    header = source.text.split("\n", 1)[0].lower().replace('"', "")
    return [name.strip() for name in header.split(",")] == list(COLUMNS)


def read(source: AlignmentFile) -> Recording:
    """A tier for each type (words, phones) and speaker."""
    tracks: dict[tuple[str, str], list[Interval]] = {}
    for number, row in _rows(source):
        try:
            start, end, label, kind, speaker = row
            interval = Interval(label.strip(), float(start), float(end))
        except ValueError as error:
            raise source.error(f"row {number} is damaged ({error}); export it again") from error
        tracks.setdefault((kind, speaker), []).append(interval)
    tiers = [
        Tier(kind, tuple(sorted(track, key=lambda interval: interval.start)), n, speaker)
        for n, ((kind, speaker), track) in enumerate(tracks.items(), 1)
    ]
    last = max((interval.end for tier in tiers for interval in tier.intervals), default=0.0)
    return Recording(tuple(tiers), 0.0, last)


def _rows(source: AlignmentFile) -> Iterator[tuple[int, list[str]]]:
    """The rows below the header that are not empty, and their numbers."""
    try:
        for number, row in enumerate(csv.reader(source.text.splitlines()[1:]), 2):
            if row:
                yield number, row
    except csv.Error as error:
        raise source.error(f"has a damaged row ({error}); export it again") from error
