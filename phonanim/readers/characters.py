"""Times of characters, as ElevenLabs and Inworld give them with their speech; they form words.

Inworld may add the phones of each word.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

from phonanim.readers._words import TimedWord, tables, word_recording
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "character times of ElevenLabs and Inworld (JSON)"


class Layout(NamedTuple):
    """Names of the lists of characters, starts, and ends or durations, and the unit of time in seconds."""

    characters: str
    starts: str
    lasts: str
    are_durations: bool
    unit: float


LAYOUTS = (
    Layout("characters", "character_start_times_seconds", "character_end_times_seconds", False, 1.0),
    Layout("characters", "characterStartTimeSeconds", "characterEndTimeSeconds", False, 1.0),
    Layout("characters", "characterStartTimesSeconds", "characterEndTimesSeconds", False, 1.0),
    Layout("chars", "charStartTimesMs", "charDurationsMs", True, 1e-3),
    Layout("chars", "charStartTimesMs", "charsDurationsMs", True, 1e-3),
    Layout("chars", "charsStartTimesMs", "charsDurationsMs", True, 1e-3),
    Layout("chars", "char_start_times_ms", "char_durations_ms", True, 1e-3),
    Layout("words", "wordStartTimeSeconds", "wordEndTimeSeconds", False, 1.0),
)
Character = tuple[str, float, float]
SILENCE = "[silence]"


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with lists of characters and of their times, in one piece or in lines."""
    return next(_alignments(source.json_lines), None) is not None


def read(source: AlignmentFile) -> Recording:
    """The words; a piece of a stream whose times start again continues the piece before it."""
    characters: list[Character] = []
    phones: list[Interval] = []
    unit = 1.0
    try:
        for table, layout in _alignments(source.json_lines):
            piece, unit = _characters(table, layout), layout.unit
            end = characters[-1][2] if characters else 0.0
            moved = end if piece and piece[0][1] < end - unit else 0.0
            characters += [(text, start + moved, last + moved) for text, start, last in piece]
            phones += _phones(table, moved)
    except DAMAGE as error:
        raise source.error(f"has damaged times of characters ({error!r}); synthesize it again") from error
    end = max((last for *_, last in characters), default=0.0)
    recording = word_recording(_words(characters), end, unit=unit)
    if not phones:
        return recording
    return replace(recording, tiers=(*recording.tiers, Tier("phones", tuple(phones), 2)))


def _alignments(lines: list[Any]) -> Iterator[tuple[dict[str, Any], Layout]]:
    """Each table of times; of the text as written and as normalized, what was written first counts."""
    for line in lines:
        if not isinstance(line, (dict, list)):
            continue
        for outer in line if isinstance(line, list) else [line]:
            found = [
                (table, layout)
                for table in tables(outer)
                for layout in LAYOUTS
                if isinstance(table.get(layout.starts), list)
                and layout.lasts in table
                and isinstance(table.get(layout.characters), list)
            ]
            yield from found[:1]


def _characters(table: dict[str, Any], layout: Layout) -> list[Character]:
    texts, starts, lasts = table[layout.characters], table[layout.starts], table[layout.lasts]
    if not len(texts) == len(starts) == len(lasts):
        raise ValueError(f"{len(texts)} characters, {len(starts)} starts and {len(lasts)} ends")
    spaced = [text if layout.characters != "words" else f"{text} " for text in map(str, texts)]
    return [
        (text, float(start) * layout.unit, (float(last) + layout.are_durations * float(start)) * layout.unit)
        for text, start, last in zip(spaced, starts, lasts, strict=True)
    ]


def _phones(table: dict[str, Any], moved: float) -> Iterator[Interval]:
    """The phones of the words, where Inworld gives them."""
    for word in table.get("phoneticDetails") or ():
        for phone in word["phones"]:
            start = float(phone["startTimeSeconds"]) + moved
            label = str(phone["phoneSymbol"])
            yield Interval("" if label == SILENCE else label, start, start + float(phone["durationSeconds"]))


def _words(characters: list[Character]) -> Iterator[TimedWord]:
    word, first, last = "", 0.0, 0.0
    for text, start, end in characters:
        if text.strip():
            word, first = word + text.strip(), first if word else start
            last = end
        if word and (not text.strip() or text[-1:].isspace()):
            yield TimedWord(word, first, last)
            word = ""
    if word:
        yield TimedWord(word, first, last)
