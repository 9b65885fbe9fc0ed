"""JSON of speech recognizers and synthesizers: words, or lines of text, with their times in seconds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from phonanim.readers._services import find_layouts
from phonanim.readers._words import (
    SPREAD,
    UNTIMED,
    TimedWord,
    check_count,
    first_value,
    seconds,
    spread_text,
    word_recording,
)
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "word times of WhisperX, Whisper, OpenAI, Vosk, Kokoro and others (JSON)"

# Keys of a word and its times; the same in Whisper, whisper-timestamped, OpenAI, Vosk, Deepgram, Kokoro and
# transformers, but for the names.
WORD = ("word", "punctuated_word", "text")
START = ("start", "start_time", "start_ts")
END = ("end", "end_time", "end_ts")
LENGTH = ("duration", "dur")
LISTS = ("word_segments", "words", "result", "timestamps", "tokens")
# Keys of words that other readers read: their times have other names, or they come with their sounds.
OTHERS = (
    *("phonemes", "phoneme_ts", "case", "Phonemes", "startTime", "startOffset", "alignedWord"),
    *("alignment", "phones", "phone_label"),
)
SOUNDS = ("phonemes", "phones")


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with words or lines of text that have times in seconds; some may have null."""
    items = list(_items(source.json_lines))
    if not any(map(_has_times, items)) or any(_is_of_another(item) for item in items):
        return False
    sounds = any(isinstance(line, dict) and any(map(line.get, SOUNDS)) for line in source.json_lines)
    return not sounds and not find_layouts(source.json_lines)


def read(source: AlignmentFile) -> Recording:
    """One tier of words for each speaker; a line of text that has no words shares its time among them."""
    words: list[TimedWord] = []
    spread = False
    try:
        for item in _items(source.json_lines):
            word = _word(item)
            if " " in word.text and math.isfinite(word.end - word.start):
                words += spread_text(word.text, word.start, word.end, word.speaker)
                check_count(words)
                spread = spread or words[-1].text != word.text
            else:
                words.append(word)
        end = max((seconds(part["end"]) for part in _segments(source.json_lines)), default=0.0)
    except DAMAGE as error:
        raise source.error(f"is a damaged list of words ({error!r}); recognize again") from error
    notes = (SPREAD,) if spread else ()
    return word_recording(words, end if math.isfinite(end) else 0.0, notes, spoken=_language(source))


def _has_times(item: dict[str, Any]) -> bool:
    """Whether an item has a start and an end, or says that it has none."""
    if isinstance(pair := item.get("timestamp"), list):
        return len(pair) == 2 and not isinstance(pair[0], list)
    return any(name in item for name in START)


def _is_of_another(item: dict[str, Any]) -> bool:
    """Whether an item is a word of a format that has a reader of its own."""
    return any(key in item for key in OTHERS) or isinstance(first_value(item, (*START, *END)), dict)


def _word(item: dict[str, Any]) -> TimedWord:
    start, end = first_value(item, START), first_value(item, END)
    if isinstance(pair := item.get("timestamp"), list) and len(pair) == 2:
        start, end = pair
    text = first_value(item, WORD)
    if isinstance(text, (dict, list)):
        raise TypeError("a word is a table")
    times = (UNTIMED, UNTIMED) if start is None else (seconds(start), seconds(end))
    if end is None and start is not None and (length := first_value(item, LENGTH)) is not None:
        times = (times[0], times[0] + seconds(length))
    speaker = first_value(item, ("speaker", "speaker_id"))
    return TimedWord(str(text).strip(), *times, "" if speaker is None else str(speaker))


def _items(lines: list[Any]) -> Iterator[dict[str, Any]]:
    """Every word, and every line of text that has no words, in the order of the file."""
    for content in lines:
        if isinstance(content, dict) and _is_word(content) and not _holds_words(content):
            yield content  # a stream of words
        else:
            yield from _words(content, 0)


def _words(content: Any, depth: int) -> Iterator[dict[str, Any]]:
    if depth > 8:
        return
    if isinstance(content, list):
        for item in content:
            if isinstance(item, dict) and (_holds_words(item) or not _is_word(item)):
                yield from _words(item, depth + 1)
            elif isinstance(item, dict):
                yield item
        return
    if not isinstance(content, dict):
        return
    parts = content.get("segments") or content.get("chunks")
    found = list(_words(parts, depth + 1)) if isinstance(parts, list) else []
    if not found or not any(_is_single(item) for item in found):
        lists = [content[name] for name in LISTS if isinstance(content.get(name), list) and content[name]]
        found = list(_words(lists[0], depth + 1)) if lists else found
    yield from found
    for name in ("results", "channels", "channel", "alternatives", "transcription") if not found else ():
        inner = content.get(name)
        # Of alternatives, the others say the same otherwise.
        if name == "alternatives" and isinstance(inner, list):
            inner = inner[:1]
        yield from _words(inner, depth + 1)


def _holds_words(item: dict[str, Any]) -> bool:
    return any(isinstance(item.get(name), list) and item[name] for name in (*LISTS[1:3], "segments"))


def _is_word(item: dict[str, Any]) -> bool:
    """Whether an item is a word with a time, or one that WhisperX could not place."""
    timed = any(name in item for name in (*START, "timestamp"))
    return first_value(item, WORD) is not None and (timed or "word" in item)


def _is_single(item: dict[str, Any]) -> bool:
    return " " not in str(first_value(item, WORD)).strip()


def _segments(lines: list[Any]) -> Iterator[dict[str, Any]]:
    for content in lines:
        parts = content.get("segments") if isinstance(content, dict) else None
        for part in parts if isinstance(parts, list) else ():
            if isinstance(part, dict) and isinstance(part.get("end"), (int, float)):
                yield part


def _language(source: AlignmentFile) -> str:
    """The language that the recognizer found, "" when the file does not say."""
    first = source.json_lines[0] if source.json_lines else None
    found = first.get("language") if isinstance(first, dict) else None
    return found if isinstance(found, str) else ""
