"""Words of Google's speech service, as JSON: times as "1.300s", or as seconds and nanoseconds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from phonanim.readers._words import TimedWord, first_value, tables, word_recording
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Google speech results (JSON)"
STARTS = ("startTime", "startOffset", "start_time", "start_offset")
ENDS = ("endTime", "endOffset", "end_time", "end_offset")


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with words whose times are of this kind; a start of 0 may be left out."""
    return next(_words(source), None) is not None


def read(source: AlignmentFile) -> Recording:
    """One tier of words for each speaker of the first alternatives."""
    try:
        words = [
            TimedWord(
                str(word["word"]),
                _seconds(first_value(word, STARTS)),
                _seconds(first_value(word, ENDS)),
                str(first_value(word, ("speakerLabel", "speakerTag", "speaker_tag")) or ""),
            )
            for word in _words(source)
        ]
    except DAMAGE as error:
        raise source.error(f"has a damaged word ({error!r}); recognize again") from error
    return word_recording(words, spoken=_language(source))


def _words(source: AlignmentFile) -> Iterator[dict[str, Any]]:
    results = [table for table in tables(source.json_lines) if isinstance(table.get("alternatives"), list)]
    firsts = [table["alternatives"][0] for table in results if table["alternatives"]]
    # With diarization, the last result repeats every word with its speaker.
    tagged = [one for one in firsts if any(_is_tagged(word) for word in _listed(one))]
    for part in tagged[-1:] or firsts or source.json_lines:
        yield from (word for word in _listed(part) if _is_word(word))


def _listed(part: Any) -> list[Any]:
    words = part.get("words") if isinstance(part, dict) else part
    return words if isinstance(words, list) else []


def _is_word(word: Any) -> bool:
    if not isinstance(word, dict) or "word" not in word:
        return False
    end = first_value(word, ENDS)
    return isinstance(end, dict) or (isinstance(end, str) and end.endswith("s"))


def _is_tagged(word: Any) -> bool:
    return isinstance(word, dict) and bool(first_value(word, ("speakerLabel", "speakerTag", "speaker_tag")))


def _seconds(time: Any) -> float:
    if time is None:
        return 0.0
    if isinstance(time, dict):
        return float(time.get("seconds") or 0) + float(time.get("nanos") or 0) * 1e-9
    return float(str(time).removesuffix("s"))


def _language(source: AlignmentFile) -> str:
    codes = (first_value(table, ("languageCode", "language_code")) for table in tables(source.json_lines))
    return next((code for code in codes if isinstance(code, str)), "")
