from pathlib import Path

import pytest
from praatio import textgrid

from phonanim.errors import OutputError
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import fill_gaps, write_textgrid

WORDS = (Interval('say "ah"', 0.25, 1.5),)
PHONES = (Interval("AA", 0.25, 0.5), Interval("ʃ", 0.5, 1.5))


def test_gaps_are_filled():
    filled = fill_gaps(PHONES, 2.0)
    assert [(part.label, part.start, part.end) for part in filled] == [
        ("", 0.0, 0.25),
        ("AA", 0.25, 0.5),
        ("ʃ", 0.5, 1.5),
        ("", 1.5, 2.0),
    ]


def test_praatio_reads_what_was_written(tmp_path):
    write_textgrid(tmp_path / "a.TextGrid", {"words": WORDS, "phones": PHONES}, 2.0)
    grid = textgrid.openTextgrid(str(tmp_path / "a.TextGrid"), includeEmptyIntervals=False)
    assert grid.tierNames == ("words", "phones")
    assert [tuple(entry) for entry in grid.getTier("words").entries] == [(0.25, 1.5, 'say "ah"')]
    assert [tuple(entry) for entry in grid.getTier("phones").entries] == [(0.25, 0.5, "AA"), (0.5, 1.5, "ʃ")]


def test_phonanim_reads_what_was_written(tmp_path):
    write_textgrid(tmp_path / "a.TextGrid", {"words": WORDS, "phones": PHONES}, 2.0)
    alignment = read_alignment(tmp_path / "a.TextGrid")
    assert tuple(part for part in alignment.intervals if part.label) == PHONES
    assert alignment.duration == 2.0


def test_nowhere_to_write():
    with pytest.raises(OutputError, match="does not exist; make it first"):
        write_textgrid(Path("/nowhere/a.TextGrid"), {"phones": PHONES}, 2.0)
