"""Languages: convert an alignment's labels into phones of the inventory. No label is dropped silently."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from phonanim.errors import LabelError
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.alignment_file import quote_label
from phonanim.speech.labels import SILENCE_SOUND, Language, Sound, is_silent
from phonanim.speech.language_choice import choose_language
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import language_names
from phonanim.speech.letters import needs_package
from phonanim.speech.phones import PhoneTrack
from phonanim.speech.reading import ReadingLanguage, find_reading_language
from phonanim.speech.segments import SILENT, Segment, fill_gaps, merge_segments, to_track

__all__ = [
    "Language",
    "PhoneReading",
    "ReadingLanguage",
    "choose_language",
    "is_silent",
    "language_names",
    "load_language",
    "read_phones",
    "to_phones",
]

NOISE_NOTE = "not a phone, shown as silence"
MOST_GUESSED = 1000  # different labels whose nearest is shown
Unknown = Literal["error", "nearest", "silence"]


@dataclass(frozen=True, slots=True)
class PhoneReading:
    """The phones of an alignment, notes on labels that were not used as written, and the language."""

    track: PhoneTrack
    notes: tuple[str, ...]
    language: ReadingLanguage


def to_phones(
    alignment: Alignment, language: str = "auto", unknown: Unknown = "error", fallback: str | None = None
) -> tuple[PhoneTrack, tuple[str, ...]]:
    """The phones of `read_phones`, and its notes."""
    reading = read_phones(alignment, language, unknown, fallback)
    return reading.track, reading.notes


def read_phones(
    alignment: Alignment, language: str = "auto", unknown: Unknown = "error", fallback: str | None = None
) -> PhoneReading:
    """The alignment in the model's inventory, and a note for every label that was not used as written.

    Gaps are filled with silence, neighbouring silences are merged, and a closure is joined to its release.
    `auto` chooses the language by the labels, `auto:de` expects German; a note says when that is unsure.
    Raises LabelError for a label that is unknown in the language, unless `unknown` gives another treatment,
    and for a language that does not exist, unless `fallback` names another.
    """
    notes = _Notes(alignment)
    found = find_reading_language(alignment, language, fallback)
    chosen = found.language
    segments: list[Segment] = []
    for interval in alignment.intervals:
        sound = chosen.resolve(interval.label) or _replaced(interval, chosen, unknown, notes)
        if sound.kind == "noise":
            notes.add(NOISE_NOTE, interval)
        if sound.alphabet:
            notes.add(f"no label of {chosen.name}, read as {sound.alphabet}", interval)
        segments += _segments(interval, sound)
    notes.lines += found.doubt()
    if not any(segment.code != SILENT for segment in segments):
        notes.lines.append(f'no phone is spoken in tier "{quote_label(alignment.tier)}"')
    track = to_track(merge_segments(fill_gaps(segments, alignment.duration)))
    rounding = chosen.rounding_of(interval.label for interval in alignment.intervals)
    return PhoneReading(replace(track, rounding=rounding), notes.all(), found)


class _Notes:
    """The labels that were not used as written, one line for each."""

    def __init__(self, alignment: Alignment) -> None:
        self.alignment = alignment
        self.lines: list[str] = []
        self._places: dict[tuple[str, str], list[float]] = {}
        self._guessed: set[str] = set()

    def count_guess(self, interval: Interval) -> None:
        """Remember a label whose nearest is shown. Raises LabelError for more than MOST_GUESSED of them."""
        self._guessed.add(interval.label)
        if len(self._guessed) > MOST_GUESSED:
            raise LabelError(
                f"{self.alignment.source}: more than {MOST_GUESSED} different labels are not phones; "
                "choose another --tier or --language"
            )

    def add(self, what: str, interval: Interval) -> None:
        place = interval.start + self.alignment.offset
        self._places.setdefault((interval.label, what), []).append(place)

    def all(self) -> tuple[str, ...]:
        entries = self._places.items()
        found = [f'"{quote_label(label)}" at {_places(times)}: {what}' for (label, what), times in entries]
        return (*self.alignment.notes, *found, *self.lines)


def _places(times: list[float]) -> str:
    more = f" and {len(times) - 1} more" if len(times) > 1 else ""
    return f"{times[0]:.2f} s{more}"


def _replaced(interval: Interval, language: Language, unknown: Unknown, notes: _Notes) -> Sound:
    """The replacement for a label that is unknown in the language, if `unknown` allows one."""
    if unknown == "error":
        tier, time = quote_label(notes.alignment.tier), interval.start + notes.alignment.offset
        place = f'{notes.alignment.source}: tier "{tier}", {time:.3f} s'
        near = ", ".join(language.nearest(interval.label)) or "none"
        package = needs_package(interval.label)
        mend = package or "choose another --language, or --on-unknown-label nearest or silence"
        what = f'no phone "{quote_label(interval.label)}" in language {language.name} (nearest: {near})'
        raise LabelError(f"{place}: {what}; {mend}")
    if unknown == "silence":
        notes.add(f"unknown in language {language.name}, shown as silence", interval)
        return SILENCE_SOUND
    notes.count_guess(interval)
    near = next(iter(language.nearest(interval.label, 1)), "")
    shown = f'"{near}"' if near else "silence: no label is similar"
    notes.add(f"unknown in language {language.name}, shown as {shown}", interval)
    return language.resolve(near) or SILENCE_SOUND


def _segments(interval: Interval, sound: Sound) -> list[Segment]:
    """The phones of one label; they share its time equally."""
    if len(sound.codes) == 1 or sound.kind == "closure":
        releases = sound.codes if sound.kind == "closure" else ()
        return [Segment(sound.codes[0], interval.start, interval.end, interval.label, releases)]
    bounds = np.linspace(interval.start, interval.end, len(sound.codes) + 1).tolist()
    return [
        Segment(code, start, end, interval.label)
        for code, start, end in zip(sound.codes, bounds, bounds[1:], strict=False)
    ]
