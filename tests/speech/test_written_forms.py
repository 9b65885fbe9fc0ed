"""Abbreviations, amounts, times, dates, units and addresses of English as words."""

from __future__ import annotations

from pathlib import Path

import pytest

from phonanim.inputs.alignment import read_alignment
from phonanim.speech.written_forms import in_english_words


@pytest.mark.parametrize(
    ("text", "spoken"),
    [
        ("Dr. Smith on Main St. near Dr. King Dr.", "Doctor Smith on Main Street near Doctor King Drive"),
        ("at 5 Oak Dr. and St. Paul", "at 5 Oak Drive and Saint Paul"),
        ("Mr. and Mrs. Jones Jr.", "mister and missus Jones junior"),
        ("Gen. Lee, not gen. x", "general Lee, not gen. x"),
        ("No. 5. I said no.", "number 5. I said no."),
        ("pp. 3-5, etc.", "pages 3 to 5, et cetera."),
        ("e.g. cats vs. dogs", "for example cats versus dogs"),
        ("It costs $5.50.", "It costs five dollars fifty cents."),
        ("$1.5 million or £3bn", "one point five million dollars or three billion pounds"),
        ("at 3:30 p.m. and 10:05", "at three thirty P M and ten oh five"),
        ("12:00, 14:00, 5 pm", "twelve o'clock, fourteen hundred, 5 P M"),
        ("99:99", "99:99"),
        ("Jan. 5 and May 21st, 2024", "January fifth and May twenty first, 2024"),
        ("May 45", "May 45"),
        ("2024-05-12 and 2024-15-12", "May twelfth twenty twenty four and 2024-15-12"),
        ("1/2, 2/3, 1/3, 24/7", "one half, two thirds, one third, 24 7"),
        ("10 km/h, 1 kg, 20°C", "ten kilometers an hour, one kilogram, twenty degrees Celsius"),
        ("5 in the 1990s, '90s", "5 in the 1990s, nineties"),
        ("It is 5 m, 5m", "It is 5 m, five meters"),
        ("5-10, 3-2, -4", "5 to 10, 3-2, minus 4"),
        ("555-123-4567", "five five five, one two three, four five six seven"),
        ("Louis XIV, War II, Henry Xy, Type IV", "Louis the fourteenth, War two, Henry Xy, Type four"),
        (
            "bob@site.co.uk, https://example.com/x/",
            "bob at site dot co dot uk, example dot com slash x",
        ),
        ("Hello. World and U.S.A.", "Hello. World and U.S.A."),
    ],
)
def test_what_is_said(text: str, spoken: str) -> None:
    assert in_english_words(text) == spoken


@pytest.mark.parametrize(
    ("word", "phones"),
    [
        ("Dr.", "D AA K T ER"),
        ("3:30", "TH R IY TH ER D IY"),
        ("$5", "F AY V D AA L ER Z"),
        ("etc.", "EH T S EH T ER AH"),
        ("Bob.", "B AA B"),
    ],
)
def test_words_with_times(tmp_path: Path, word: str, phones: str) -> None:
    pytest.importorskip("pocketsphinx")  # has the dictionary
    path = tmp_path / "x.json"
    path.write_text(f'{{"words": [{{"word": "{word}", "start": 0.2, "end": 1.4}}]}}')
    found = [one.label.rstrip("012") for one in read_alignment(path, language="en").intervals]
    assert " ".join(found) == phones
