"""Notes on the confidence of words."""

from __future__ import annotations

from phonanim.speech.doubts import doubts, recorded_doubts
from phonanim.speech.intervals import Interval, Recording, Tier

WORDS = tuple(Interval(label, n, n + 1.0) for n, label in enumerate(["the", "quick", "brown", "fox"]))


def sure(*numbers: str) -> tuple[Interval, ...]:
    return tuple(Interval(label, n, n + 1.0) for n, label in enumerate(numbers))


def test_words_that_are_sure_need_no_note() -> None:
    assert doubts(WORDS, sure("0.99", "0.60", "0.80", "1.00")) == ()
    assert doubts(WORDS, ()) == ()


def test_neighbours_are_told_together() -> None:
    assert doubts(WORDS, sure("0.99", "0.20", "0.40", "0.97")) == (
        "doubtful, check the text there: 1.0 to 3.0 s ('quick brown', 30% sure)",
    )
    assert doubts(WORDS, sure("0.10", "0.90", "0.90", "0.50")) == (
        "doubtful, check the text there: 0.0 to 1.0 s ('the', 10% sure), 3.0 to 4.0 s ('fox', 50% sure)",
    )


def test_sound_without_words() -> None:
    (note,) = doubts(WORDS[:2], (*sure("0.99", "0.99"), Interval("0.00", 2.0, 2.9)))
    assert note.endswith("2.0 to 2.9 s (sound without words of the text)")


def test_many_stretches_are_counted() -> None:
    words = tuple(Interval("a", 2.0 * n, 2.0 * n + 1) for n in range(9))
    low = tuple(Interval("0.10", word.start, word.end) for word in words)
    (note,) = doubts(words, low)
    assert note.count("10% sure") == 5
    assert note.endswith(" and 4 more")


def test_a_file_with_the_tier() -> None:
    tiers = (Tier("words", WORDS), Tier("confidence", sure("0.99", "0.20", "0.99", "0.99")))
    assert recorded_doubts(Recording(tiers, 0.0, 4.0)) == doubts(WORDS, tiers[1].intervals)
    assert recorded_doubts(Recording((tiers[0],), 0.0, 4.0)) == ()
    assert recorded_doubts(Recording((tiers[0], Tier("confidence", sure("high", "low"))), 0.0, 4.0)) == ()
