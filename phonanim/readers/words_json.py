"""JSON of speech recognizers: the words of Whisper, WhisperX and Vosk, with their times."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "word times of WhisperX, Whisper or Vosk (JSON)"


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with lists of words that have a start."""
    return next(_words(source.json), None) is not None


def read(source: AlignmentFile) -> Recording:
    """One tier of words for each speaker. WhisperX gives numbers no times; the notes list such words."""
    timed: dict[str, list[Interval]] = {}
    lost: list[str] = []
    try:
        for word in _words(source.json):
            text = str(word["word"]).strip()
            if "start" in word and "end" in word:
                interval = Interval(text, float(word["start"]), float(word["end"]))
                timed.setdefault(str(word.get("speaker", "")), []).append(interval)
            else:
                lost.append(text)
    except DAMAGE as error:
        raise source.error(f"is a damaged list of words ({error!r}); recognize again") from error
    tiers = [Tier("words", tuple(words), n, speaker) for n, (speaker, words) in enumerate(timed.items(), 1)]
    notes = [f"{len(lost)} words have no time: {', '.join(lost[:5])}"] if lost else []
    end = max((word.end for words in timed.values() for word in words), default=0.0)
    return Recording(tuple(tiers), 0.0, end, notes=tuple(notes))


def _words(content: Any) -> Iterator[dict[str, Any]]:
    """Every word: in segments (Whisper), in a list of results (Vosk), or in one list."""
    if isinstance(content, dict):
        for part in content.get("segments") or ():
            yield from _words(part)
        if "segments" not in content:
            yield from _words(content.get("words") or content.get("result"))
    elif isinstance(content, list):
        for item in content:
            if isinstance(item, dict) and "word" in item and "case" not in item:
                yield item
            elif isinstance(item, dict) and ("result" in item or "words" in item):
                yield from _words(item)
