"""Mend what aligners leave in a tier: entries of no length, small overlaps, marks, confidences."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterable
from dataclasses import replace

from phonanim.speech.alignment_file import quote_label
from phonanim.speech.intervals import ROUNDING, Interval, Tier

LARGEST_OVERLAP = 0.5
"""Share of the shorter of two phones that may overlap; more is an error of the file."""

MOST_SHOWN = 3
STRESS_MARKS = "ˈˌˊˋ'"
LENGTH_MARKS = "ːˑ:"
JOINING = 0.05  # seconds between a mark and its phone

_CONFIDENCE = re.compile(
    r"(\S+?)\s*(?:[=|/:;_]\s*|\s+|(?=[(\[{]))[(\[{]?(?:0?\.\d+|1\.0*|\d{1,3}(?:\.\d+)?\s?%)[)\]}]?"
)
_ALTERNATIVES = re.compile(r"\{([^{}=|]+)=[\d.]+(?:\|[^{}]*)?\}")


def mend_phones(tier: Tier) -> tuple[Tier, tuple[str, ...]]:
    """The tier with its marks joined and its times mended, and a note for each kind of change."""
    plain = _without_confidences(tier.intervals)
    notes = () if plain == tier.intervals else ("the confidences in the labels are not used",)
    mended, more = mend_times(replace(tier, intervals=_joined(plain)))
    return mended, (*notes, *more)


def mend_times(tier: Tier) -> tuple[Tier, tuple[str, ...]]:
    """The tier without entries of no length, and with small overlaps split in the middle.

    What is beyond that stays as it is, and is an error when the times are checked.
    """
    kept = [one for one in tier.intervals if not _is_empty(one)]
    empty = [one for one in tier.intervals if _is_empty(one) and one.label]
    split, overlaps = _split_overlaps(kept)
    notes = []
    if empty:
        notes.append(f"ignored, because it has zero length: {_places(empty)}")
    if overlaps:
        notes.append(f"overlaps the one before it, and the overlap is shared: {_places(overlaps)}")
    return replace(tier, intervals=tuple(split)), tuple(notes)


def _is_empty(interval: Interval) -> bool:
    return interval.start == interval.end and math.isfinite(interval.start)


def _split_overlaps(intervals: Iterable[Interval]) -> tuple[list[Interval], list[Interval]]:
    """The intervals with small overlaps shared, and the later ones of those that overlapped."""
    fixed: list[Interval] = []
    overlapping: list[Interval] = []
    for interval in intervals:
        last = fixed[-1] if fixed else None
        if last is not None and last.end - interval.start > ROUNDING and interval.start > last.start:
            shorter = min(last.end - last.start, interval.end - interval.start)
            if last.end - interval.start <= LARGEST_OVERLAP * shorter + ROUNDING:
                middle = (last.end + interval.start) / 2
                fixed[-1] = replace(last, end=middle)
                overlapping.append(interval)
                interval = replace(interval, start=middle)
        fixed.append(interval)
    return fixed, overlapping


def _places(intervals: list[Interval]) -> str:
    shown = ", ".join(f'"{quote_label(one.label)}" at {one.start:.2f} s' for one in intervals[:MOST_SHOWN])
    more = len(intervals) - MOST_SHOWN
    return f"{shown} and {more} more" if more > 0 else shown


def _joined(intervals: tuple[Interval, ...]) -> tuple[Interval, ...]:
    """Marks that stand alone become part of the phone before them, or, for stress, of the one after."""
    joined: list[Interval] = []
    stress: Interval | None = None
    for interval in intervals:
        mark = _is_mark(interval.label)
        last = joined[-1] if joined else None
        if mark and set(interval.label) <= set(STRESS_MARKS):
            stress = stress or interval
        elif mark and last is not None and last.label and interval.start - last.end < JOINING:
            end = max(last.end, interval.end)
            joined[-1] = replace(last, label=last.label + interval.label.strip(LENGTH_MARKS), end=end)
        elif not mark:
            near = stress is not None and interval.label and interval.start - stress.end < JOINING
            joined.append(replace(interval, start=stress.start) if near and stress is not None else interval)
            stress = None
    return tuple(joined)


def _is_mark(label: str) -> bool:
    """Whether a label is only marks of stress, length or articulation, without a letter."""
    known = STRESS_MARKS + LENGTH_MARKS
    return bool(label) and all(
        c in known or unicodedata.category(c) == "Mn" or "\u02b0" <= c <= "\u02ff" for c in label
    )


def _without_confidences(intervals: tuple[Interval, ...]) -> tuple[Interval, ...]:
    """Labels without a confidence behind them, such as `m=0.98` or `m (97%)`, if most labels have one."""
    labels = [one.label for one in intervals if one.label]
    plain = {label: _plain_label(label) for label in set(labels)}
    if 2 * sum(plain[label] != label for label in labels) <= len(labels):
        return intervals
    return tuple(replace(one, label=plain.get(one.label, one.label)) for one in intervals)


def _plain_label(label: str) -> str:
    """A label without its confidence; of several alternatives, the first, as SPPAS puts the best first."""
    if found := _ALTERNATIVES.fullmatch(label):
        return found[1].strip()
    found = _CONFIDENCE.fullmatch(label)
    return found[1] if found else label
