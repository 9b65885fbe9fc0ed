"""TextGrids as praatio writes them for us: whole, valid and exact."""

from pathlib import Path

import numpy as np
import pytest
from praatio import textgrid
from textgrid_text import long_text

from phonanim.errors import OutputError
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

WORDS = (Interval('say "ah"', 0.25, 1.5),)
PHONES = (Interval("AA", 0.25, 0.5), Interval("ʃ", 0.5, 1.5))


def test_the_text_is_that_of_praat(tmp_path):
    write_textgrid(tmp_path / "a.TextGrid", {"words": WORDS}, 2.0)
    written = (tmp_path / "a.TextGrid").read_text("utf-8")
    entries = [(0, 0.25, ""), (0.25, 1.5, 'say "ah"'), (1.5, 2, "")]
    assert written == long_text([("words", entries)], end=2)


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


def test_times_keep_every_digit(tmp_path):
    phones = (Interval("AA", 0.1 + 0.2, 1 / 3), Interval("M", 1 / 3, 1e-5 + 1))
    write_textgrid(tmp_path / "a.TextGrid", {"phones": phones}, np.float64(2 / 3 + 1))
    alignment = read_alignment(tmp_path / "a.TextGrid")
    assert tuple(part for part in alignment.intervals if part.label) == phones
    assert alignment.duration == 2 / 3 + 1


def test_overlapping_intervals_are_refused(tmp_path):
    overlapping = (Interval("AA", 0.0, 0.6), Interval("M", 0.5, 1.0))
    message = r"a.TextGrid: cannot be written as a TextGrid: Two intervals .* overlap in time: .*; correct"
    with pytest.raises(OutputError, match=message) as error:
        write_textgrid(tmp_path / "a.TextGrid", {"phones": overlapping}, 1.0)
    assert "\n" not in str(error.value)
    assert not list(tmp_path.iterdir())


def test_nowhere_to_write():
    with pytest.raises(OutputError, match="does not exist; create it first"):
        write_textgrid(Path("/nowhere/a.TextGrid"), {"phones": PHONES}, 2.0)
