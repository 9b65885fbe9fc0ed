"""Times for words that have none: recognizers leave numbers and doubtful words without a start or an end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from phonanim.speech.alignment_file import quote_label
from phonanim.speech.intervals import Interval, Recording, Tier
from phonanim.speech.repair import mend_times

LONGEST = 0.6
"""Seconds that a word without a time may last at most."""

SHORTEST = 0.08
"""Seconds that a word needs at least; where its gap is shorter, its neighbours give of theirs."""

GIVEN = 0.4
"""Share of its time that a neighbour gives at most."""

MOST_SHOWN = 5


def settle_words(tiers: Sequence[Tier], recording: Recording) -> tuple[list[Tier], tuple[str, ...]]:
    """Tiers of words with a time for every word: one without a time gets one between its neighbours.

    A word of no length counts as one without a time. The notes say which words were placed so, and where
    an overlap of two words was shared.
    """
    settled: list[Tier] = []
    placed: list[str] = []
    notes: list[str] = []
    for tier in tiers:
        whole, names = _settled(tier, recording)
        mended, more = mend_times(whole)
        settled.append(mended)
        placed += names
        notes += more
    if placed:
        shown = ", ".join(quote_label(name) for name in placed[:MOST_SHOWN])
        more_words = f" and {len(placed) - MOST_SHOWN} more" if len(placed) > MOST_SHOWN else ""
        notes.insert(0, f"placed between their neighbours, because they have no time: {shown}{more_words}")
    return settled, tuple(notes)


def _settled(tier: Tier, recording: Recording) -> tuple[Tier, list[str]]:
    words = _with_ends(tier.intervals)
    lost = [word.label for word in words if not _is_timed(word)]
    if not lost:
        return replace(tier, intervals=tuple(words)), []
    first = 0
    while first < len(words):
        last = first
        while last < len(words) and not _is_timed(words[last]):
            last += 1
        if last > first:
            _place(words, first, last, recording)
        first = last + 1
    return replace(tier, intervals=tuple(words)), lost


def _with_ends(words: Sequence[Interval]) -> list[Interval]:
    """The words; one with a start but no end ends where the next one starts."""
    ended: list[Interval] = []
    following = math.inf
    for word in reversed(words):
        if math.isnan(word.end) and math.isfinite(word.start):
            limit = following if following > word.start else math.inf
            word = replace(word, end=min(limit, word.start + LONGEST))
        if math.isfinite(word.start):
            following = word.start
        ended.append(word)
    return ended[::-1]


def _is_timed(word: Interval) -> bool:
    return word.end > word.start or math.isinf(word.end) or math.isinf(word.start) or word.end < word.start


def _place(words: list[Interval], first: int, last: int, recording: Recording) -> None:
    """Give times to the words from `first` up to `last`, in the gap between the words around them."""
    count = last - first
    before = words[first - 1] if first else None
    after = words[last] if last < len(words) else None
    end = after.start if after else _last_end(before, count, recording)
    start = before.end if before else max(recording.start, 0.0, end - count * LONGEST) if after else 0.0
    missing = count * SHORTEST - (end - start)
    if missing > 0 and before is not None:
        start = max(start - missing, before.end - GIVEN * (before.end - before.start))
        words[first - 1] = replace(before, end=start)
    missing = count * SHORTEST - (end - start)
    if missing > 0 and after is not None:
        end = min(end + missing, after.start + GIVEN * (after.end - after.start))
        words[last] = replace(after, start=end)
    end = min(end, start + count * LONGEST) if before else end
    _share(words, first, last, start, end)


def _last_end(before: Interval | None, count: int, recording: Recording) -> float:
    """Where the last words may end: at the end of the recording, if that leaves them some time."""
    start = before.end if before else 0.0
    room = recording.end - start
    return recording.end if room >= count * SHORTEST else start + count * LONGEST / 2


def _share(words: list[Interval], first: int, last: int, start: float, end: float) -> None:
    """Share the time from `start` to `end` by the letters of each word."""
    weights = [len(word.label) + 2 for word in words[first:last]]
    step = (end - start) / sum(weights)
    for n, weight in zip(range(first, last), weights, strict=True):
        words[n] = Interval(words[n].label, start, start + weight * step)
        start += weight * step
