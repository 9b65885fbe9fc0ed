"""JSON of the Gentle aligner: words with the durations of their phones."""

from __future__ import annotations

from typing import Any

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Gentle JSON"


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with words that have a case (success or not found)."""
    words = source.json.get("words") if isinstance(source.json, dict) else None
    return isinstance(words, list) and any(isinstance(word, dict) and "case" in word for word in words)


def read(source: AlignmentFile) -> Recording:
    """The phones and words that were found; the notes list the words that were not found."""
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


def _phones(word: dict[str, Any]) -> list[Interval]:
    intervals = []
    start = float(word["start"])
    for phone in word["phones"]:
        end = start + float(phone["duration"])
        intervals.append(Interval(str(phone["phone"]), start, end))
        start = end
    return intervals
