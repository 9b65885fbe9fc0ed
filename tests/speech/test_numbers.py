"""Numbers as English words."""

from __future__ import annotations

import pytest

from phonanim.speech.numbers import spell_number


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0", "zero"),
        ("7", "seven"),
        ("42", "forty two"),
        ("100", "one hundred"),
        ("1,024", "one thousand twenty four"),
        ("5000000", "five million"),
        ("1984", "nineteen eighty four"),
        ("1905", "nineteen oh five"),
        ("1900", "nineteen hundred"),
        ("2007", "two thousand seven"),
        ("2024", "twenty twenty four"),
        ("1990s", "nineteen nineties"),
        ("3rd", "third"),
        ("21st", "twenty first"),
        ("30th", "thirtieth"),
        ("12th", "twelfth"),
        ("2.05", "two point zero five"),
        ("$5", "five dollars"),
        ("$1.50", "one dollar fifty cents"),
        ("20%", "twenty percent"),
        ("007", "zero zero seven"),
        ("1" * 13, "one " * 13),
        ("x", ""),
        ("1.2.3", ""),
        ("9" * 50, ""),
    ],
)
def test_numbers(text: str, words: str) -> None:
    assert spell_number(text) == words.split()
