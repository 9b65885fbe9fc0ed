"""Output of the Gentle aligner: JSON of words with the durations of their phones, or CSV of words."""

from __future__ import annotations

import re
from typing import Any

from phonanim.readers._rows import all_match, split
from phonanim.readers._words import UNTIMED, TimedWord, word_recording
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Gentle JSON and CSV"

_TIME = r"(\d+\.\d+)?"
_ROW = re.compile(rf"([^,]+),([^,]*),{_TIME},{_TIME}")


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with words that have a case (success or not found), or rows of words and times."""
    if source.json is None:
        return any(row[3] and row[4] for row in all_match(source, _ROW))
    words = source.json.get("words") if isinstance(source.json, dict) else None
    return isinstance(words, list) and any(isinstance(word, dict) and "case" in word for word in words)


def read(source: AlignmentFile) -> Recording:
    """The phones and words that were found; the notes list the words that were not found."""
    if source.json is None:
        return _from_rows(source)
    try:
        found = [word for word in source.json["words"] if "start" in word and "phones" in word]
        lost = [str(word["word"]) for word in source.json["words"] if "start" not in word]
        phones = tuple(phone for word in found for phone in _phones(word))
        words = tuple(Interval(word["word"], float(word["start"]), float(word["end"])) for word in found)
    except DAMAGE as error:
        raise source.error(f"is damaged Gentle output ({error!r}); align again") from error
    notes = [f"the aligner did not find {len(lost)} words: {', '.join(lost[:5])}"] if lost else []
    end = max((interval.end for interval in (*phones, *words)), default=0.0)
    return Recording((Tier("phones", phones, 1), Tier("words", words, 2)), 0.0, end, notes=tuple(notes))


def _from_rows(source: AlignmentFile) -> Recording:
    """The words; one that was not found has no time."""
    rows = split(source, _ROW)
    return word_recording(TimedWord(row[1], _seconds(row[3]), _seconds(row[4])) for row in rows)


def _seconds(text: str | None) -> float:
    return float(text) if text else UNTIMED


def _phones(word: dict[str, Any]) -> list[Interval]:
    intervals = []
    start = float(word["start"])
    for phone in word["phones"]:
        end = start + float(phone["duration"])
        intervals.append(Interval(str(phone["phone"]), start, end))
        start = end
    return intervals
