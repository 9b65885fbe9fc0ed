"""Subtitles of SubStation Alpha (ASS, SSA): lines of text with clock times; karaoke marks time syllables."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from phonanim.readers._cues import Cue, cue_recording, plain_cue
from phonanim.readers._highlights import StyledCue, spoken_words
from phonanim.readers._times import clock_seconds
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "SubStation Alpha subtitles (ASS, SSA)"
CENTISECOND = 0.01
USUAL = ["layer", "start", "end", "style", "name", "marginl", "marginr", "marginv", "effect", "text"]

_MARKS = re.compile(r"\{([^{}]*)\}")
_SYLLABLE = re.compile(r"\\(?:k|K|kf|ko)(\d+)")
_DRAWING = re.compile(r"\\p[1-9]")


class Event(NamedTuple):
    """A line of dialogue, with its marks, from `start` to `end` seconds."""

    start: float
    end: float
    text: str
    name: str


def recognizes(source: AlignmentFile) -> bool:
    """Whether there is a section of events with lines of dialogue."""
    return bool(re.search(r"^\[Events\]\s*$", source.text, re.MULTILINE)) and "\nDialogue:" in source.text


def read(source: AlignmentFile) -> Recording:
    """The words of each speaker; those of a line share its time, but where karaoke marks time them."""
    try:
        return cue_recording(_without_marked(list(_events(source))))
    except DAMAGE as error:
        raise source.error(f"has a damaged line of dialogue ({error}); save it again") from error


def _events(source: AlignmentFile) -> Iterator[Event]:
    fields = USUAL
    for line in source.text.partition("[Events]")[2].splitlines():
        kind, _, rest = line.partition(":")
        if kind == "Format":
            fields = [name.strip().lower() for name in rest.split(",")]
        elif kind == "Dialogue":
            values = dict(zip(fields, rest.strip().split(",", len(fields) - 1), strict=True))
            if not _DRAWING.search(values["text"]):
                start, end = clock_seconds(values["start"]), clock_seconds(values["end"])
                name = values.get("name", values.get("actor", "")).strip()
                yield Event(start, end, re.sub(r"\\[Nnh]", " ", values["text"]), name)


def _without_marked(events: list[Event]) -> list[Cue]:
    """The events; where a line is shown once for each word with that word marked, the marked words."""
    cues = [Cue(one.start, one.end, tuple(_pieces(one.text, one.start)), one.name) for one in events]
    if any(map(_SYLLABLE.search, (one.text for one in events))):
        return cues
    styled = [StyledCue(one.start, one.end, _runs(one.text)) for one in events]
    found = spoken_words(styled)
    if found == styled:
        return cues
    return [plain_cue(one.start, one.end, "".join(text for _, text in one.runs)) for one in found]


def _runs(text: str) -> tuple[tuple[str, str], ...]:
    """The text of an event by its marks; \\r goes back to the style of the line."""
    parts = _MARKS.split(text)
    styles = ["", *("" if mark.startswith("\\r") else mark for mark in parts[1::2])]
    return tuple((style, part) for style, part in zip(styles, parts[::2], strict=True) if part)


def _pieces(text: str, start: float) -> Iterator[tuple[float, str]]:
    """The text of each syllable with its start; without karaoke marks the whole text."""
    parts = _MARKS.split(text)
    spoken, time, following = parts[0], start, start
    for marks, after in zip(parts[1::2], parts[2::2], strict=True):
        for length in map(int, _SYLLABLE.findall(marks)):
            yield time, spoken
            spoken, time = "", following
            following += length * CENTISECOND
        spoken += after
    yield time, spoken
    if following > time:
        yield following, ""
