"""Edit distances: the laws of a distance, and the slow recursion that defines it."""

from __future__ import annotations

from functools import cache

from hypothesis import given
from hypothesis import strategies as st

from phonanim.metrics import edit_distance

WORDS = st.text("abc", max_size=6)


@cache
def slow(one: str, other: str) -> int:
    if not one or not other:
        return len(one) + len(other)
    changed = slow(one[1:], other[1:]) + (one[0] != other[0])
    return min(changed, slow(one[1:], other) + 1, slow(one, other[1:]) + 1)


@given(WORDS, WORDS)
def test_it_is_the_least_number_of_edits(one: str, other: str) -> None:
    assert edit_distance(one, other) == slow(one, other) == edit_distance(other, one)


def test_parts_are_compared_whole() -> None:
    assert edit_distance(["rounded", "open"], ["rounded", "closed", "open"]) == 1
    assert edit_distance("kitten", "sitting") == 3
