"""Viseme events of Azure's text to speech, as JSON: a viseme's number and its offset."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from phonanim.readers._rows import from_starts
from phonanim.readers._visemes import AZURE, NOTE, merge_repeats
from phonanim.readers._words import tables
from phonanim.speech.alignment import Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Azure viseme events (JSON)"
LAST = 0.1  # seconds of the last viseme, which no event ends

# Names of the offset with their unit in seconds: the SDK counts ticks of 100 ns, some logs milliseconds.
OFFSETS = {
    **{"audiooffset": 1e-7, "offset": 1e-7, "audiooffsetticks": 1e-7},
    **{"audiooffsetms": 1e-3, "offsetms": 1e-3, "timems": 1e-3, "tms": 1e-3, "time": 1e-3, "timestamp": 1e-3},
}


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with numbers of visemes and offsets."""
    return next(_events(source.json_lines), None) is not None


def read(source: AlignmentFile) -> Recording:
    """The visemes, each until the next one, as the phones that they stand for."""
    try:
        events = [
            (float(event[name]) * OFFSETS[name], AZURE[int(event["visemeid"])], name)
            for event, name in _events(source.json_lines)
        ]
    except DAMAGE as error:
        raise source.error(f"has a damaged viseme ({error!r}); record the events again") from error
    starts = sorted(((start, label) for start, label, _ in events), key=lambda pair: pair[0])
    shapes = merge_repeats(from_starts(starts, starts[-1][0] + LAST))
    unit = OFFSETS[events[0][2]]
    return Recording((Tier("phones", shapes),), 0.0, starts[-1][0] + LAST, (NOTE,), "english", unit)


def _events(lines: list[Any]) -> Iterator[tuple[dict[str, Any], str]]:
    """Each event with keys in small letters, and the name of its offset."""
    for table in tables(lines):
        event = {key.lower().replace("_", ""): value for key, value in table.items()}
        name = next((name for name in OFFSETS if name in event), "")
        if "visemeid" in event and name:
            yield event, name
