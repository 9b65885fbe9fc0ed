"""Speech marks of Amazon Polly: a line of JSON for each word and viseme, with its time in milliseconds."""

from __future__ import annotations

from typing import Any

from phonanim.readers._rows import from_starts
from phonanim.readers._visemes import NOTE, POLLY, merge_repeats
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Amazon Polly speech marks"
MILLISECOND = 1e-3
LAST_VISEME, LAST_WORD = 0.1, 0.4  # seconds of the last mark, which nothing ends
KINDS = ("sentence", "word", "viseme", "ssml")


def recognizes(source: AlignmentFile) -> bool:
    """Whether every value of the file is a mark with a time, a kind and a text."""
    marks = _marks(source)
    return bool(marks) and all(
        isinstance(mark, dict) and mark.get("type") in KINDS and {"time", "value"} <= mark.keys()
        for mark in marks
    )


def read(source: AlignmentFile) -> Recording:
    """The visemes as the phones that they stand for, and the words; each lasts until the next one."""
    try:
        visemes = [(time, POLLY.get(value, value)) for time, value in _of(source, "viseme")]
        words = _of(source, "word")
    except DAMAGE as error:
        raise source.error(f"has a damaged mark ({error!r}); synthesize it again") from error
    last = max([time for time, _ in visemes[-1:]] + [time for time, _ in words[-1:]], default=0.0)
    end = last + (LAST_VISEME if visemes else LAST_WORD)
    tiers = []
    if visemes:
        tiers.append(Tier("phones", merge_repeats(from_starts(visemes, visemes[-1][0] + LAST_VISEME)), 1))
    if words:
        tiers.append(Tier("words", _until_next(words, end), 2))
    notes, language = ((NOTE,), "english") if visemes else ((), "")
    return Recording(tuple(tiers), 0.0, end, notes, language, MILLISECOND)


def _marks(source: AlignmentFile) -> list[Any]:
    lines = source.json_lines
    return lines[0] if len(lines) == 1 and isinstance(lines[0], list) else lines


def _of(source: AlignmentFile, kind: str) -> list[tuple[float, str]]:
    marks = (mark for mark in _marks(source) if mark["type"] == kind)
    return [(float(mark["time"]) * MILLISECOND, str(mark["value"])) for mark in marks]


def _until_next(words: list[tuple[float, str]], end: float) -> tuple[Interval, ...]:
    return tuple(word for word in from_starts(words, end) if word.end > word.start)
