"""Subtitles of SubStation Alpha (ASS, SSA): lines of text with clock times; karaoke marks time syllables."""

from __future__ import annotations

import re
from collections.abc import Iterator

from phonanim.readers._cues import Cue, cue_recording
from phonanim.readers._times import clock_seconds
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "SubStation Alpha subtitles (ASS, SSA)"
CENTISECOND = 0.01
USUAL = ["layer", "start", "end", "style", "name", "marginl", "marginr", "marginv", "effect", "text"]

_MARKS = re.compile(r"\{([^}]*)\}")
_SYLLABLE = re.compile(r"\\(?:k|K|kf|ko)(\d+)")
_DRAWING = re.compile(r"\\p[1-9]")


def recognizes(source: AlignmentFile) -> bool:
    """Whether there is a section of events with lines of dialogue."""
    return bool(re.search(r"^\[Events\]\s*$", source.text, re.MULTILINE)) and "\nDialogue:" in source.text


def read(source: AlignmentFile) -> Recording:
    """The words of each speaker; those of a line share its time, but where karaoke marks time them."""
    try:
        return cue_recording(_cues(source))
    except DAMAGE as error:
        raise source.error(f"has a damaged line of dialogue ({error}); save it again") from error


def _cues(source: AlignmentFile) -> Iterator[Cue]:
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
                yield Cue(start, end, tuple(_pieces(values["text"], start)), name)


def _pieces(text: str, start: float) -> Iterator[tuple[float, str]]:
    """The text of each syllable with its start; without karaoke marks the whole text."""
    text = re.sub(r"\\[Nnh]", " ", text)
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
