"""JSON of speech services: words, and sounds where they are given, by the table lexicon/word_times.toml."""

from __future__ import annotations

import re
from collections.abc import Iterable

from phonanim.readers._services import Entry, Layout, entries, find_layouts, language_of
from phonanim.readers._words import SPREAD, UNTIMED, TimedWord, check_count, spread_text, word_recording
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "words of AssemblyAI, whisper.cpp, Amazon Transcribe, Speechmatics, Cartesia and others (JSON)"

_SPECIAL = re.compile(r"\[_[A-Z]+_?\d*_?\]|<\|[^|]*\|>")  # tokens that are not spoken


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON in one of the layouts of the table."""
    return bool(find_layouts(source.json_lines))


def read(source: AlignmentFile) -> Recording:
    """One tier of words for each speaker, and one of phones if the service gives sounds."""
    words: list[TimedWord] = []
    phones: list[Interval] = []
    found = find_layouts(source.json_lines)
    try:
        for layout in found:
            given = list(entries(layout, source.json_lines))
            if layout.gives == "phones":
                phones += _phones(given, layout.seconds)
            else:
                words += _words(layout, given)
        spoken = next(filter(None, (language_of(one, source.json_lines) for one in found)), "")
    except DAMAGE as error:
        raise source.error(f"has a damaged entry ({error!r}); save the result again") from error
    notes = (SPREAD,) if any(one.gives == "lines" for one in found) else ()
    end = max((phone.end for phone in phones), default=0.0)
    recording = word_recording(words, end, notes, found[0].seconds, spoken)
    if not phones:
        return recording
    tiers = (*recording.tiers, Tier("phones", tuple(phones), len(recording.tiers) + 1))
    return Recording(tiers, 0.0, recording.end, notes, unit=found[0].seconds, spoken=spoken)


def _words(layout: Layout, given: Iterable[Entry]) -> list[TimedWord]:
    words: list[TimedWord] = []
    joined = True  # a piece of a word belongs to the one before it
    for entry in given:
        if layout.gives == "pieces" and _SPECIAL.fullmatch(entry.label.strip()):
            joined = False
            continue
        start = UNTIMED if entry.start is None else entry.start * layout.seconds
        end = UNTIMED if entry.end is None else entry.end * layout.seconds
        fresh = entry.label[:1].isspace() or not words or not joined
        joined = True
        if layout.gives == "pieces" and not fresh:
            last = words[-1]
            words[-1] = TimedWord(last.text + entry.label, last.start, max(last.end, end), last.speaker)
        elif layout.gives == "lines":
            words += spread_text(entry.label, start, end, entry.speaker)
            check_count(words)
        elif any(c.isalnum() for c in entry.label):
            words.append(TimedWord(entry.label, start, end, entry.speaker))
    return words


def _phones(given: Iterable[Entry], unit: float) -> list[Interval]:
    """The sounds, without blanks and punctuation."""
    phones: list[Interval] = []
    for entry in given:
        label = entry.label.strip().strip("ˈˌ'.,!?;: ")
        if not label or entry.start is None or entry.end is None:
            continue
        start, end = entry.start * unit, entry.end * unit
        phones.append(Interval(label, start, end))
    return phones
