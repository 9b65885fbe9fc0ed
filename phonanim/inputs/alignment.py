"""Read an alignment file: find its format, its phone tier and its words, and check its times."""

from __future__ import annotations

import math
from pathlib import Path

from phonanim.readers import find_reader
from phonanim.speech.alignment import ROUNDING, Alignment, Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile, brief, open_alignment_file
from phonanim.speech.pronunciations import spell_out
from phonanim.speech.tiers import phone_tier, word_tier

MAX_DURATION = 7200.0
"""Seconds. More is a wrong unit of time or a whole session: two hours at 60 fps are 432,000 frames."""

LATE_START = 1.0
"""Seconds. A file that starts later was cut out of a longer recording, and so was its audio."""


def read_alignment(
    path: Path, tier: str | None = None, speaker: str | None = None, lexicon: Path | str | None = None
) -> Alignment:
    """The phones of an alignment file, in any format of `phonanim.readers`.

    The phone tier is found by its name, else by its labels; `tier` chooses it by name or by number
    (from 1), `speaker` by who speaks. Where a file has words alone, `lexicon` is a pronunciation
    dictionary that spells them out. Raises AlignmentError with one line when the file cannot be read,
    no tier has phones, or times make no sense.
    """
    source = open_alignment_file(Path(path))
    recording = find_reader(source).read(source)
    if lexicon is not None:
        recording = spell_out(recording, Path(lexicon), source)
    phones = phone_tier(recording, tier, speaker, source)
    words = word_tier(recording, phones)
    offset = _offset(recording, source)
    intervals = _checked(phones, offset, source)
    ends = [recording.end - offset, *(interval.end for interval in intervals[-1:])]
    return Alignment(
        intervals=intervals,
        duration=_duration(max(ends), source),
        tier=phones.name,
        source=source.name,
        words=_checked(words, offset, source) if words else (),
        offset=offset,
        notes=recording.notes + _shifted(offset),
        language=recording.language,
    )


def _shifted(offset: float) -> tuple[str, ...]:
    return (f"times are counted from {offset:g} s, where the file starts",) if offset else ()


def _offset(recording: Recording, source: AlignmentFile) -> float:
    if not (math.isfinite(recording.start) and math.isfinite(recording.end)):
        raise source.error(f"starts at {recording.start} s and ends at {recording.end} s; correct its header")
    if recording.start < -ROUNDING:
        raise source.error(f"starts at {recording.start:g} s, before 0; shift its times to zero")
    return recording.start if recording.start >= LATE_START else 0.0


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
            continue  # says nothing about any time
        start, end = interval.start - offset, interval.end - offset
        if fault := _fault(start, end, last_end):
            place = f'tier "{brief(tier.name)}", interval {number} "{brief(interval.label)}"'
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
