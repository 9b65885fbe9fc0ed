"""Words without times are placed between their neighbours."""

from __future__ import annotations

import math

from phonanim.speech.intervals import Interval, Recording, Tier
from phonanim.speech.word_times import settle_words

NONE = math.nan


def settled(
    *words: tuple[str, float, float], end: float = 0.0
) -> tuple[list[tuple[float, float]], tuple[str, ...]]:
    tier = Tier("words", tuple(Interval(*word) for word in words))
    (found,), notes = settle_words([tier], Recording((tier,), 0.0, end))
    return [(round(one.start, 3), round(one.end, 3)) for one in found.intervals], notes


def test_a_word_in_a_gap_fills_it() -> None:
    times, notes = settled(("two", 1.0, 1.4), ("2", NONE, NONE), ("tubes", 1.8, 2.4))
    assert times == [(1.0, 1.4), (1.4, 1.8), (1.8, 2.4)]
    assert notes == ("placed between their neighbours, because they have no time: 2",)


def test_words_share_a_gap_by_their_letters() -> None:
    times, _ = settled(("a", 0.0, 0.4), ("to", 0.4, 0.4), ("elephant", NONE, NONE), ("b", 1.1, 1.4))
    assert times[1:3] == [(0.4, 0.6), (0.6, 1.1)]


def test_where_there_is_no_gap_the_neighbours_give() -> None:
    times, _ = settled(("one", 0.0, 0.4), ("two", 0.4, 0.4), ("three", 0.4, 0.8))
    assert times == [(0.0, 0.32), (0.32, 0.4), (0.4, 0.8)]


def test_first_and_last_words() -> None:
    assert settled(("a", NONE, NONE), ("b", 0.3, 0.6))[0] == [(0.0, 0.3), (0.3, 0.6)]
    assert settled(("b", 0.3, 0.6), ("a", NONE, NONE), end=1.0)[0] == [(0.3, 0.6), (0.6, 1.0)]
    assert settled(("b", 0.3, 0.6), ("a", NONE, NONE))[0] == [(0.3, 0.6), (0.6, 0.9)]
    assert settled(("a", NONE, NONE), end=0.5)[0] == [(0.0, 0.5)]


def test_a_start_without_an_end_lasts_until_the_next() -> None:
    assert settled(("a", 0.1, NONE), ("b", 0.3, 0.6), ("c", 0.7, NONE)) == (
        [(0.1, 0.3), (0.3, 0.6), (0.7, 1.3)],
        (),
    )
