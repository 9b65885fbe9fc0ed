"""Viseme events of Azure's text to speech: numbers and offsets, as JSON, as a table, or as a log."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from typing import Any

from phonanim.readers._rows import LONGEST_ROW, ROWS_LOOKED_AT, from_starts, lines
from phonanim.readers._visemes import AZURE, NOTE, merge_repeats
from phonanim.readers._words import tables
from phonanim.speech.alignment import Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Azure viseme events (JSON, CSV, logs)"
LAST = 0.1  # seconds of the last viseme, which no event ends
TICK, MILLISECOND = 1e-7, 1e-3

# Names of the offset, without a prefix, and their unit in seconds; None where programs write several units:
# the SDK counts ticks of 100 ns, and logs write milliseconds or seconds under the same name.
OFFSETS: dict[str, float | None] = {
    **{"audiooffset": None, "offset": None, "time": None, "timestamp": None, "audiooffsetticks": TICK},
    **dict.fromkeys(("audiooffsetms", "offsetms", "timems", "tms", "audiooffsetmilliseconds"), MILLISECOND),
}
FEWEST_TICKS, FEWEST_MILLISECONDS = 20_000, 2
"""Mean difference of two offsets, 2 ms, from which they are ticks, or milliseconds; else they are seconds."""

_LOGGED = re.compile(
    r"audio[ _]?offset:?\s*(\d+(?:\.\d+)?)\s*(?:\(?ms\)?|milliseconds)?\D{0,20}viseme[ _]?id:?\s*(\d+)",
    re.IGNORECASE,
)


def recognizes(source: AlignmentFile) -> bool:
    """Whether there are numbers of visemes with offsets."""
    return next(_events(source, ROWS_LOOKED_AT), None) is not None


def read(source: AlignmentFile) -> Recording:
    """The visemes, each until the next one, as the phones that they stand for."""
    try:
        events = [
            (float(event[name]), AZURE[int(event["visemeid"])], name) for event, name in _events(source)
        ]
        unit = OFFSETS[events[0][2]] or _unit([time for time, *_ in events])
    except DAMAGE as error:
        raise source.error(f"has a damaged viseme ({error!r}); record the events again") from error
    starts = sorted(((time * unit, label) for time, label, _ in events), key=lambda pair: pair[0])
    shapes = merge_repeats(from_starts(starts, starts[-1][0] + LAST))
    return Recording((Tier("phones", shapes),), 0.0, starts[-1][0] + LAST, (NOTE,), "english", unit)


def _unit(times: list[float]) -> float:
    """The seconds of a number by the mean difference of offsets."""
    mean = (max(times) - min(times)) / max(len(times) - 1, 1)
    return TICK if mean >= FEWEST_TICKS else MILLISECOND if mean >= FEWEST_MILLISECONDS else 1.0


def _events(source: AlignmentFile, most: int | None = None) -> Iterator[tuple[dict[str, Any], str]]:
    """Each event with plain keys, and the name of its offset."""
    for table in tables(source.json_lines) if source.json_lines else _rows(source, most):
        event = {_plain(key): value for key, value in table.items()}
        name = next((name for name in OFFSETS if name in event), "")
        if "visemeid" in event and name:
            yield event, name


def _plain(key: str) -> str:
    """A key in small letters, without the prefix that the SDK for JavaScript gives to fields."""
    return re.sub(r"[^a-z]", "", key.lower()).removeprefix("priv")


def _rows(source: AlignmentFile, most: int | None) -> Iterator[dict[str, Any]]:
    """The events in the first rows of a table with a header, or of a log."""
    rows = lines(source)[:most]
    if not rows or len(rows[0]) > LONGEST_ROW:
        return
    if "visemeid" in _plain(rows[0]) and not _LOGGED.search(rows[0]):
        yield from csv.DictReader(rows, delimiter=max("\t;,", key=rows[0].count), restkey="", restval="")
        return
    for row in rows:
        if len(row) <= LONGEST_ROW and (found := _LOGGED.search(row)):
            yield {"offset ms": found[1], "viseme id": found[2]}
