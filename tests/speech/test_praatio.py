"""praatio's objects in and out, and what its reader does not read as Praat does.

Each quirk is a file that praatio 6 refuses or reads wrongly and that our tokenizer reads. The day praatio is
mended, the quirk's test fails; once none is left, praatio can read for us (docs/decisions).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from praatio import textgrid
from praatio.data_classes.interval_tier import IntervalTier
from praatio.data_classes.point_tier import PointTier
from praatio.data_classes.textgrid import Textgrid
from praatio.utilities.errors import DuplicateTierName, ParsingError, TextgridStateError
from textgrid_text import BEAM, WORDS, Entry, long_text, short_text

from phonanim.errors import AlignmentError
from phonanim.inputs.alignment import read_alignment
from phonanim.readers import find_reader
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.alignment_file import open_alignment_file

TWO: list[Entry] = [(0, 0.5, "B"), (0.5, 1, "IY")]
READ_AS_TWO = [(0.0, 0.5, "B"), (0.5, 1.0, "IY")]
CHRONOLOGICAL = """"Praat chronological TextGrid text file"
0 1   ! Time domain.
1   ! Number of tiers.
"IntervalTier" "phones" 0 1
1 0 0.5
"B"
1 0.5 1
"IY"
"""


def labelled(label: str) -> list[Entry]:
    return [(0, 0.5, label), (0.5, 1, "IY")]


def commented(text: str) -> str:
    """The text with a comment before its first number, as Praat allows anywhere."""
    return text.replace("\n\n", "\n\n! by hand\n", 1)


@dataclass(frozen=True)
class Quirk:
    """A file, what praatio makes of it (an exception or entries), and what stands in it (None: damage)."""

    content: str | bytes
    praatio: type[Exception] | list[tuple[Any, ...]]
    entries: list[tuple[Any, ...]] | None


QUIRKS = {
    "two tiers of one name": Quirk(
        long_text([("phones", TWO), ("phones", TWO)]), DuplicateTierName, READ_AS_TWO
    ),
    "an overlap of 0.1 microseconds": Quirk(
        long_text([("phones", [(0, 0.5000001, "B"), (0.5, 1, "IY")])]),
        TextgridStateError,
        [(0.0, 0.5000001, "B"), (0.5, 1.0, "IY")],
    ),
    "an empty interval without length": Quirk(
        long_text([("phones", [(0, 0.5, "B"), (0.5, 0.5, ""), (0.5, 1, "IY")])]),
        TextgridStateError,
        [(0.0, 0.5, "B"), (0.5, 0.5, ""), (0.5, 1.0, "IY")],
    ),
    "Latin-1": Quirk(
        long_text([("phones", labelled("é"))]).encode("latin-1"),
        UnicodeDecodeError,
        [(0.0, 0.5, "é"), (0.5, 1.0, "IY")],
    ),
    "a label that looks like an entry": Quirk(
        long_text([("phones", labelled("x\nintervals [2]:\nxmin = 3"))]),
        ParsingError,
        [(0.0, 0.5, "x\nintervals [2]:\nxmin = 3"), (0.5, 1.0, "IY")],
    ),
    "a label that looks like a tier, long text": Quirk(
        long_text([("phones", labelled("item [1]:"))]),
        ParsingError,
        [(0.0, 0.5, "item [1]:"), (0.5, 1.0, "IY")],
    ),
    "a label that looks like a tier, short text": Quirk(
        short_text([("phones", labelled("item [1]:"))]),
        IndexError,
        [(0.0, 0.5, "item [1]:"), (0.5, 1.0, "IY")],
    ),
    "a label that quotes the class of a tier": Quirk(
        short_text([("phones", labelled('"IntervalTier"'))]),
        ValueError,
        [(0.0, 0.5, '"IntervalTier"'), (0.5, 1.0, "IY")],
    ),
    "the name of a tier on two lines": Quirk(long_text([("the\nphones", TWO)]), ParsingError, READ_AS_TWO),
    "a time in scientific notation": Quirk(
        long_text([("phones", [(0, "1e-05", ""), ("1e-05", 1, "IY")])]),
        ParsingError,
        [(0.0, 1e-05, ""), (1e-05, 1.0, "IY")],
    ),
    "a time below zero loses its sign": Quirk(
        long_text([("phones", [(-0.25, 0.5, "B"), (0.5, 1, "IY")])]),
        [(0.25, 0.5, "B"), (0.5, 1.0, "IY")],
        [(-0.25, 0.5, "B"), (0.5, 1.0, "IY")],
    ),
    "no line end after the last label": Quirk(
        short_text([("phones", TWO)]).rstrip("\n"), [(0.0, 0.5, "B")], READ_AS_TWO
    ),
    "fewer entries than announced": Quirk(
        long_text([("phones", TWO)]).replace("size = 2", "size = 3"), READ_AS_TWO, None
    ),
    "cut short, long text": Quirk(long_text([("phones", TWO)])[:-20], ParsingError, None),
    "cut short, short text": Quirk(short_text([("phones", TWO)])[:-20], [], None),
    "another kind of object": Quirk(
        long_text([("phones", TWO)]).replace('"TextGrid"', '"PitchTier"'), READ_AS_TWO, None
    ),
    "comments": Quirk(commented(long_text([("phones", TWO)])), IndexError, READ_AS_TWO),
    "free layout": Quirk(
        'File type = "ooTextFile" Object class = "TextGrid" 0 1 <exists> 1\n'
        '"IntervalTier" "phones" 0 1 2  0 0.5 "B"  0.5 1 "IY"\n',
        IndexError,
        READ_AS_TWO,
    ),
    "no tier, short text": Quirk(short_text([]), IndexError, []),
    "chronological text": Quirk(CHRONOLOGICAL, ValueError, READ_AS_TWO),
}


def read_by_praatio(path: Path) -> list[tuple[Any, ...]]:
    tiers = textgrid.openTextgrid(str(path), includeEmptyIntervals=True, reportingMode="silence").tiers
    return [tuple(entry) for tier in tiers for entry in tier.entries]


@pytest.mark.parametrize("quirk", QUIRKS.values(), ids=QUIRKS)
def test_what_praatio_drops(tmp_path: Path, quirk: Quirk) -> None:
    path = tmp_path / "a.TextGrid"
    path.write_bytes(quirk.content if isinstance(quirk.content, bytes) else quirk.content.encode())
    if isinstance(quirk.praatio, list):
        assert read_by_praatio(path) == quirk.praatio
    else:
        with pytest.raises(quirk.praatio):
            read_by_praatio(path)


@pytest.mark.parametrize("quirk", QUIRKS.values(), ids=QUIRKS)
def test_what_our_reader_keeps(tmp_path: Path, quirk: Quirk) -> None:
    path = tmp_path / "a.TextGrid"
    path.write_bytes(quirk.content if isinstance(quirk.content, bytes) else quirk.content.encode())
    source = open_alignment_file(path)
    if quirk.entries is None:
        with pytest.raises(AlignmentError, match=r"truncated or damaged|not a TextGrid"):
            find_reader(source).read(source)
        return
    tiers = find_reader(source).read(source).tiers
    assert [(i.start, i.end, i.label) for tier in tiers[:1] for i in tier.intervals] == quirk.entries


FAITHFUL: dict[str, bytes] = {
    "long text": long_text([("words", WORDS), ("phones", BEAM)]).encode(),
    "short text": short_text([("words", WORDS), ("phones", BEAM)]).encode(),
    "UTF-16": long_text([("phones", labelled("ʃ"))]).encode("utf-16"),
    "UTF-8 with a mark": long_text([("phones", labelled("ʃ"))]).encode("utf-8-sig"),
    "carriage returns": long_text([("phones", TWO)]).replace("\n", "\r\n").encode(),
    "quotation marks": short_text([("phones", labelled('say "B"'))]).encode(),
    "a label on two lines": long_text([("phones", labelled("B\nC"))]).encode(),
    "a tier without entries": long_text([("words", []), ("phones", TWO)]).encode(),
    "a point tier": short_text([("phones", TWO)])
    .replace("<exists>\n1\n", '<exists>\n2\n"TextTier"\n"bell"\n0\n1\n1\n0.1\n"H*"\n')
    .encode(),
    "a file cut out of a longer one": long_text(
        [("phones", [(100, 100.5, "B"), (100.5, 101, "IY")])], start=100, end=101
    ).encode(),
}


@pytest.mark.parametrize("content", FAITHFUL.values(), ids=FAITHFUL)
def test_an_object_of_praatio_is_read_as_its_file(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.TextGrid"
    path.write_bytes(content)
    opened = textgrid.openTextgrid(str(path), includeEmptyIntervals=True)
    assert Alignment.from_praatio(opened, source=str(path)) == read_alignment(path)


def test_an_alignment_comes_back_from_praatio(tmp_path: Path) -> None:
    path = tmp_path / "a.TextGrid"
    path.write_text(long_text([("words", WORDS), ("phones", BEAM)]), "utf-8")
    alignment = read_alignment(path)
    made = alignment.to_praatio()
    assert made.tierNames == ("words", "phones")
    assert made == textgrid.openTextgrid(str(path), includeEmptyIntervals=True)
    assert Alignment.from_praatio(made, source=str(path)) == alignment


def test_to_praatio_keeps_the_clock_of_the_file() -> None:
    alignment = Alignment((Interval("B", 0.25, 0.5),), 1.0, "phones", "a.TextGrid", offset=100.0)
    made = alignment.to_praatio()
    assert (made.minTimestamp, made.maxTimestamp) == (100.0, 101.0)
    assert [tuple(entry) for entry in made.getTier("phones").entries] == [(100.25, 100.5, "B")]


def test_tiers_of_an_object_are_chosen_as_those_of_a_file() -> None:
    made = Textgrid()
    made.addTier(PointTier("bell", [(0.1, "H*")], 0.0, 1.0))
    made.addTier(IntervalTier("A - phones", [(0.0, 1.0, "B")], 0.0, 1.0))
    made.addTier(IntervalTier("B - phones", [(0.0, 1.0, "M")], 0.0, 1.0))
    with pytest.raises(AlignmentError, match=r"^TextGrid: has several phone tiers, 2 \"A - phones\", 3 "):
        Alignment.from_praatio(made)
    assert Alignment.from_praatio(made, speaker="B").intervals == (Interval("M", 0.0, 1.0),)
    assert Alignment.from_praatio(made, tier="2").intervals == (Interval("B", 0.0, 1.0),)
