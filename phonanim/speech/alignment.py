"""Alignments: the phones of one recording with their times, by an aligner or by hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from phonanim.speech.alignment_file import AlignmentFile, quote_label
from phonanim.speech.clock import (
    ANY,
    Clock,
    cut_before,
    length_notes,
    scale_times,
    settle_offset,
    settle_unit,
)
from phonanim.speech.intervals import (
    ROUNDING,
    Interval,
    Recording,
    Tier,
    pack_intervals,
    unpack_intervals,
)
from phonanim.speech.repair import mend_phones, mend_times
from phonanim.speech.textgrid import textgrid_from, tiers_of
from phonanim.speech.tiers import PHONE_NAMES, best_named_tiers, phone_tier, word_tier

if TYPE_CHECKING:
    from praatio.data_classes.textgrid import Textgrid

__all__ = ["ROUNDING", "Alignment", "Interval", "Recording", "Tier", "pack_intervals", "unpack_intervals"]

MAX_DURATION = 7200.0
"""Seconds. A longer file has a wrong unit of time or is a whole session: 2 h at 60 fps are 432,000 frames."""


MOST_TIERS = 1000
"""A session of twenty speakers with five tiers each has a hundred."""


@dataclass(frozen=True, slots=True)
class Alignment:
    """The phone tier of one recording.

    `intervals` are in time order and do not overlap; gaps between them are silence.
    `duration` is the end of the file in seconds, `tier` the name of the tier that was read,
    `source` the path for error messages, `words` the word tier if the file has one.
    `offset` is the time on the file's clock that is 0 here; it is not 0 for a part of a longer recording.
    `notes` report the assumptions of the reader, `language` that of the labels if the format fixes it.

    Examples:
        >>> import phonanim
        >>> alignment = phonanim.read_alignment("line.TextGrid")
        >>> [word.label for word in alignment.words[1:4]]
        ['my', 'father', 'watched']
    """

    intervals: tuple[Interval, ...]
    duration: float
    tier: str
    source: str
    words: tuple[Interval, ...] = ()
    offset: float = 0.0
    notes: tuple[str, ...] = ()
    language: str = ""

    @classmethod
    def from_recording(
        cls,
        recording: Recording,
        source: AlignmentFile,
        tier: str | None = None,
        speaker: str | None = None,
        lexicon: Path | str | None = None,
        unknown: str = "error",
        language: str = "auto",
        clock: Clock = ANY,
    ) -> Alignment:
        """The phones of a recording. The arguments and errors are those of `read_alignment`."""
        _check_header(recording, source)
        if not best_named_tiers(recording.tiers, PHONE_NAMES):
            from phonanim.speech.pronunciations import spell_out

            recording = spell_out(recording, Path(lexicon) if lexicon else None, source, unknown, language)
        chosen = phone_tier(recording, tier, speaker, source)
        factor, scaled = settle_unit(recording, chosen, clock, source)
        recording, chosen = scale_times(recording, chosen, factor)
        phones, mended = mend_phones(chosen)
        words = word_tier(recording, chosen)
        offset, shifted = settle_offset(recording, phones, clock)
        shifted += length_notes(recording, phones, offset, clock)
        if clock.offset is not None:
            phones, words = cut_before(phones, offset), words and cut_before(words, offset)
        intervals = _checked(phones, offset, source)
        ends = [recording.end - offset, *(interval.end for interval in intervals[-1:])]
        return cls(
            intervals=intervals,
            duration=_duration(max(ends), source),
            tier=phones.name,
            source=source.name,
            words=_checked(mend_times(words)[0], offset, source) if words else (),
            offset=offset,
            notes=recording.notes + scaled + mended + shifted,
            language=recording.language,
        )

    @classmethod
    def from_praatio(
        cls,
        textgrid: Textgrid,
        tier: str | None = None,
        speaker: str | None = None,
        lexicon: Path | str | None = None,
        source: str = "TextGrid",
    ) -> Alignment:
        """The phones of a praatio `Textgrid`, found as `read_alignment` finds them in a file.

        `source` names the TextGrid in messages. Raises AlignmentError as `read_alignment` does.
        """
        origin = AlignmentFile(source, source, b"")
        return cls.from_recording(tiers_of(textgrid), origin, tier, speaker, lexicon)

    def to_praatio(self) -> Textgrid:
        """A praatio `Textgrid` with the words (if any) and the phones, on the file's clock."""
        tiers = {"words": self.words} if self.words else {}
        tiers[self.tier or "phones"] = self.intervals
        moved = {
            name: [Interval(one.label, one.start + self.offset, one.end + self.offset) for one in intervals]
            for name, intervals in tiers.items()
        }
        return textgrid_from(moved, self.offset, self.offset + self.duration)


def _check_header(recording: Recording, source: AlignmentFile) -> None:
    """Raise AlignmentError for a start or an end that cannot be."""
    if not (math.isfinite(recording.start) and math.isfinite(recording.end)):
        raise source.error(f"starts at {recording.start} s and ends at {recording.end} s; correct its header")
    if len(recording.tiers) > MOST_TIERS:
        raise source.error(
            f"has {len(recording.tiers)} tiers, more than {MOST_TIERS}; save those of the speaker alone"
        )
    if recording.start < -ROUNDING:
        raise source.error(f"starts at {recording.start:g} s, before 0; shift its times to zero")


def _duration(seconds: float, source: AlignmentFile) -> float:
    if seconds > MAX_DURATION:
        hours = f"{seconds / 3600:.1f} hours long, over the limit of {MAX_DURATION / 3600:.0f}"
        raise source.error(f"is {hours}; split it, or correct its unit of time")
    if seconds < ROUNDING:
        raise source.error("has no duration; align the recording again")
    return seconds


def _checked(tier: Tier, offset: float, source: AlignmentFile) -> tuple[Interval, ...]:
    """The intervals on a clock that starts at `offset`, in order and without overlap."""
    checked: list[Interval] = []
    last_end = 0.0
    for number, interval in enumerate(tier.intervals, 1):
        if interval.start == interval.end and not interval.label:
            continue  # covers no time
        start, end = interval.start - offset, interval.end - offset
        if fault := _fault(start, end, last_end):
            place = f'tier "{quote_label(tier.name)}", interval {number} "{quote_label(interval.label)}"'
            raise source.error(f"{place} from {interval.start:g} to {interval.end:g} s: {fault}")
        start = start if start - last_end > ROUNDING else last_end
        checked.append(Interval(interval.label, start, end))
        last_end = end
    return tuple(checked)


def _fault(start: float, end: float, last_end: float) -> str:
    if not (math.isfinite(start) and math.isfinite(end)):
        return "its time is not a number; correct it"
    if end < start:
        return "ends before it starts; swap its times"
    if start < last_end - ROUNDING:
        return "overlaps the one before it" if last_end else "starts before the file; shift the times"
    if end <= max(start, last_end):
        return "has no length; remove it or give it one"
    return ""
