"""Phones corrected by hand, which are corrected in the same way when the line is aligned again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from difflib import SequenceMatcher

import numpy as np

from phonanim.errors import OptionError
from phonanim.speech.alignment import Alignment
from phonanim.speech.anchors import Anchors, match_phones
from phonanim.speech.intervals import Interval

SHORTEST = 0.005  # seconds of a phone
SAME = 5e-4  # seconds: instants nearer to each other are one


@dataclass(frozen=True, slots=True)
class PhoneChanges:
    """The phones as they were read, and as they were corrected. Both are in time order, without overlap."""

    before: tuple[Interval, ...] = ()
    after: tuple[Interval, ...] = ()


def check_phones(phones: tuple[Interval, ...], duration: float) -> None:
    """Raise OptionError for corrected phones that overlap, are too short, or lie outside the line."""
    last = 0.0
    for phone in phones:
        what = f"{phone.label or 'an empty label'} {phone.start:.3f}-{phone.end:.3f} s"
        if phone.end - phone.start < SHORTEST - 1e-9:
            raise OptionError(f"{what}: a phone lasts at least {SHORTEST:g} s")
        if phone.start < last - 1e-9 or phone.end > duration + SAME:
            raise OptionError(f"{what}: phones follow one another, from 0 to {duration:.3f} s")
        last = phone.end


def correct_phones(alignment: Alignment, changes: PhoneChanges) -> tuple[Alignment, tuple[str, ...]]:
    """An alignment with the corrections of an earlier one of the line, and notes on those that do not fit.

    Phones of both alignments are matched by their labels, in order. Where a corrected stretch is said again,
    it takes the corrected phones, with their times moved as the phones around them moved.
    """
    if not changes.before and not changes.after:
        return alignment, ()
    given = alignment.intervals
    anchors = match_phones(changes.before, given)
    pieces: list[tuple[int, int, tuple[Interval, ...]]] = []
    notes: list[str] = []
    for first, last, low, high in _changed_stretches(changes):
        place = _place(anchors, first, last, len(changes.before), len(given))
        if place is None:
            said = " ".join(phone.label for phone in changes.before[first:last] if phone.label)
            notes.append(f"the correction of the phones {said} was left out: they are no longer spoken there")
            continue
        own, wanted = changes.before[first:last], changes.after[low:high]
        stretch = _fitted(own, wanted, given[place[0] : place[1]], anchors)
        pieces.append((*place, stretch))
    return replace(alignment, intervals=_joined(given, pieces)), tuple(notes)


def _changed_stretches(changes: PhoneChanges) -> Iterator[tuple[int, int, int, int]]:
    """Places [first, last) of phones as read that became those at [low, high) of the corrected ones."""
    matcher = SequenceMatcher(None, _keys(changes.before), _keys(changes.after), autojunk=False)
    for kind, first, last, low, high in matcher.get_opcodes():
        if kind != "equal":
            yield first, last, low, high


def _keys(phones: tuple[Interval, ...]) -> list[tuple[str, int, int]]:
    return [(phone.label, round(phone.start / SAME), round(phone.end / SAME)) for phone in phones]


def _place(anchors: Anchors, first: int, last: int, before: int, after: int) -> tuple[int, int] | None:
    """Where a stretch is in the other alignment, as places [first, last); None where it is not said again.

    A stretch without a phone, into which some were put, lies between those around it.
    """
    if first == last:
        left = anchors.found.get(first - 1) if first else -1
        right = anchors.found.get(first) if first < before else after
        return None if left is None or right != left + 1 else (right, right)
    found = [anchors.found.get(place) for place in range(first, last)]
    start = found[0]
    if start is None or found != list(range(start, start + len(found))):
        return None
    return start, start + len(found)


def _fitted(
    own: tuple[Interval, ...], wanted: tuple[Interval, ...], given: tuple[Interval, ...], anchors: Anchors
) -> tuple[Interval, ...]:
    """Corrected phones on the time of another alignment, in which the phones `own` are `given`."""
    before, after = anchors.before, anchors.after
    if own:
        before, first = np.unique([(phone.start, phone.end) for phone in own], return_index=True)
        after = np.ravel([(phone.start, phone.end) for phone in given])[first]
    starts = np.interp([phone.start for phone in wanted], before, after)
    ends = np.interp([phone.end for phone in wanted], before, after)
    return tuple(
        Interval(phone.label, float(start), float(end))
        for phone, start, end in zip(wanted, starts, ends, strict=True)
    )


def _joined(
    given: tuple[Interval, ...], pieces: list[tuple[int, int, tuple[Interval, ...]]]
) -> tuple[Interval, ...]:
    """Phones with stretches replaced; what would overlap the phone before it begins later."""
    found: list[Interval] = []
    place = 0
    for first, last, stretch in pieces:
        found += [*given[place:first], *stretch]
        place = last
    found += given[place:]
    clear: list[Interval] = []
    for phone in found:
        start = max(phone.start, clear[-1].end if clear else 0.0)
        if phone.end - start > SHORTEST / 2:
            clear.append(replace(phone, start=start))
    return tuple(clear)
