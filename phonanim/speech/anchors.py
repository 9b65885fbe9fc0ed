"""Two takes of a line, matched by their phones: where an instant of one is in the other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import OptionError
from phonanim.speech.intervals import Interval

Array = NDArray[np.float64]

MOST_PAIRS = 20_000_000  # of equal phones of both takes: lines of half an hour have 15 million
FAR = 1e6  # seconds; before the first phone and after the last, times move with that phone


@dataclass(frozen=True, slots=True)
class Anchors:
    """The phones of one take that were found in another, and the new time of each of its instants.

    `found` maps places of phones to places in the other take.
    """

    found: dict[int, int]
    before: Array
    after: Array

    def moved(self, times: Sequence[float]) -> Array:
        """Seconds of the one take -> seconds of the other."""
        return np.interp(times, self.before, self.after)


def match_phones(before: tuple[Interval, ...], after: tuple[Interval, ...]) -> Anchors:
    """Match the phones of two takes by their labels, in order. Raises OptionError for very long takes."""
    pairs = list(_pairs(_labels(before), _labels(after)))
    old = [time for one, _ in pairs for time in (before[one].start, before[one].end)] or [0.0]
    new = [time for _, two in pairs for time in (after[two].start, after[two].end)] or [0.0]
    places, first = np.unique([old[0] - FAR, *old, old[-1] + FAR], return_index=True)
    instants = np.array([new[0] - FAR, *new, new[-1] + FAR])[first]
    return Anchors(dict(pairs), places, instants)


def _pairs(before: list[str], after: list[str]) -> Iterator[tuple[int, int]]:
    """Places of equal labels in order: those from the start and up to the end first, as they cost no search.

    Raises OptionError where too many are left to be searched.
    """
    shorter = min(len(before), len(after))
    first = next((place for place in range(shorter) if before[place] != after[place]), shorter)
    left = shorter - first
    last = next((place for place in range(left) if before[-1 - place] != after[-1 - place]), left)
    yield from ((place, place) for place in range(first))
    old, new = before[first : len(before) - last], after[first : len(after) - last]
    here, there = Counter(old), Counter(new)
    if sum(count * there[label] for label, count in here.items()) > MOST_PAIRS:
        raise OptionError(
            f"lines of {len(before)} and {len(after)} phones are too long to be matched; cut them in parts"
        )
    for block in SequenceMatcher(None, old, new, autojunk=False).get_matching_blocks():
        yield from ((first + block.a + k, first + block.b + k) for k in range(block.size))
    yield from ((len(before) - k, len(after) - k) for k in range(last, 0, -1))


def match_takes(
    before: tuple[Interval, ...], read: tuple[Interval, ...], after: tuple[Interval, ...]
) -> Anchors:
    """Match the phones of a take with those of another, whose phones were corrected after they were read.

    The first may have been made before the correction: then its phones are those that were read.
    """
    direct = match_phones(before, after)
    if not read or read == after:
        return direct
    first = match_phones(before, read)
    if len(first.found) <= len(direct.found):
        return direct
    second = match_phones(read, after)
    return Anchors(first.found, first.before, second.moved(first.after.tolist()))


def _labels(phones: tuple[Interval, ...]) -> list[str]:
    return [phone.label for phone in phones]
