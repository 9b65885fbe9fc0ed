"""Entries of no length, small overlaps, marks that stand alone, confidences."""

from __future__ import annotations

import pytest

from phonanim.speech.intervals import Interval, Tier
from phonanim.speech.repair import mend_phones

Entries = list[tuple[str, float, float]]


def mended(entries: Entries) -> tuple[Entries, tuple[str, ...]]:
    tier, notes = mend_phones(Tier("phones", tuple(Interval(*entry) for entry in entries)))
    return [(one.label, round(one.start, 6), round(one.end, 6)) for one in tier.intervals], notes


def test_entries_of_no_length_are_passed_over_with_a_note() -> None:
    entries = [("m", 0.0, 0.1), ("sp", 0.1, 0.1), ("a", 0.1, 0.2), ("", 0.2, 0.2)]
    assert mended(entries) == (
        [("m", 0.0, 0.1), ("a", 0.1, 0.2)],
        ('ignored, because it has zero length: "sp" at 0.10 s',),
    )


def test_small_overlaps_are_shared_and_large_ones_are_kept_for_the_check() -> None:
    assert mended([("m", 0.0, 0.12), ("a", 0.1, 0.3)]) == (
        [("m", 0.0, 0.11), ("a", 0.11, 0.3)],
        ('overlaps the one before it, and the overlap is shared: "a" at 0.10 s',),
    )
    apart = [("m", 0.0, 0.2), ("a", 0.08, 0.3)]
    assert mended(apart) == (apart, ())


def test_marks_that_stand_alone_belong_to_their_phone() -> None:
    entries = [("ˈ", 0.0, 0.05), ("a", 0.05, 0.1), ("ː", 0.1, 0.2), ("k", 0.2, 0.3), ("ʷ", 0.3, 0.32)]
    assert mended(entries)[0] == [("a", 0.0, 0.2), ("kʷ", 0.2, 0.32)]
    assert mended([("ː", 0.0, 0.1), ("", 0.1, 0.2), ("̃", 0.2, 0.3)])[0] == [("", 0.1, 0.2)]


@pytest.mark.parametrize("suffix", ["=0.98", " (97%)", "|0.5", " 0.73", "/1.00"])
def test_confidences_are_no_part_of_labels(suffix: str) -> None:
    found, notes = mended([(f"m{suffix}", 0.0, 0.1), ("", 0.1, 0.2), (f"a{suffix}", 0.2, 0.3)])
    assert [label for label, *_ in found] == ["m", "", "a"]
    assert notes == ("the confidences in the labels are not used",)


def test_the_first_of_alternatives_counts() -> None:
    assert mended([("{a=0.8|b=0.2}", 0.0, 0.1)])[0] == [("a", 0.0, 0.1)]


def test_labels_with_numbers_of_their_own_stay() -> None:
    entries = [("AH0", 0.0, 0.1), ("a:", 0.1, 0.2), ("ian2", 0.2, 0.3), ("B_B", 0.3, 0.4)]
    assert mended(entries) == (entries, ())
