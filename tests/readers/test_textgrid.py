"""TextGrids in every form that Praat and its imitators write are read alike."""

from __future__ import annotations

import codecs
from pathlib import Path

import pytest
from textgrid_text import BEAM, WORDS, Entry, long_text, save, short_text

from phonanim.errors import AlignmentError
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.alignment import Alignment, Interval

TIERS = [("words", WORDS), ("phones", BEAM)]
PHONES = tuple(Interval(label, float(start), float(end)) for start, end, label in BEAM)


def read(folder: Path, text: str, tier: str | None = None) -> Alignment:
    return read_alignment(save(folder, text), tier)


@pytest.mark.parametrize("write", [long_text, short_text])
@pytest.mark.parametrize("bom", [b"", codecs.BOM_UTF8])
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_long_and_short_forms_with_any_line_end(tmp_path: Path, write, bom: bytes, newline: str) -> None:
    path = tmp_path / "a.TextGrid"
    path.write_bytes(bom + write(TIERS).replace("\n", newline).encode())
    alignment = read_alignment(path)
    assert alignment.intervals == PHONES
    assert alignment.tier == "phones"
    assert alignment.duration == 1.0
    assert [word.label for word in alignment.words] == ["", "beam", ""]
    assert alignment.source == str(path)


@pytest.mark.parametrize(
    ("encoding", "bom"),
    [("utf-16-le", codecs.BOM_UTF16_LE), ("utf-16-be", codecs.BOM_UTF16_BE), ("latin-1", b"")],
)
def test_encodings(tmp_path: Path, encoding: str, bom: bytes) -> None:
    entries: list[Entry] = [(0, 0.5, "é"), (0.5, 1, "B")]
    path = tmp_path / "a.TextGrid"
    path.write_bytes(bom + long_text([("phones", entries)]).encode(encoding))
    assert [i.label for i in read_alignment(path).intervals] == ["é", "B"]


def test_layout_and_comments_carry_nothing(tmp_path: Path) -> None:
    text = """File type = "ooTextFile"   ! what follows "is" 3 comments
    Object class = "TextGrid" 0 1 <exists>
    ! one tier
    1 "IntervalTier" "phones" 0 1 2   0 0.5 "B" from 0.5 seconds to 1 seconds we hear "IY1" """
    assert [(i.label, i.start, i.end) for i in read(tmp_path, text).intervals] == [
        ("B", 0, 0.5),
        ("IY1", 0.5, 1),
    ]


@pytest.mark.parametrize("write", [long_text, short_text])
def test_labels_that_look_like_structure(tmp_path: Path, write) -> None:
    odd = ['say "B"', '"IntervalTier"', "item [1]:", "intervals [2]:\nxmin = 3", "! no comment", '"""', "1.5"]
    entries: list[Entry] = [(i / 5, (i + 1) / 5, label) for i, label in enumerate(odd)]
    found = read(tmp_path, write([("odd one", entries)], end=1.4), tier="odd one")
    assert [interval.label for interval in found.intervals] == odd


def test_numbers_as_programs_write_them(tmp_path: Path) -> None:
    entries: list[Entry] = [("-0", "5e-01", "B"), (".5", "1.", "IY")]
    found = read(tmp_path, short_text([("phones", entries)], start=-0.0))
    assert [(i.start, i.end) for i in found.intervals] == [(0.0, 0.5), (0.5, 1.0)]


def test_point_tiers_are_passed_over(tmp_path: Path) -> None:
    points = '"TextTier"\n"phones"\n0\n1\n2\n0.1\n"H*"\n0.4\n"L%"\n'
    text = short_text([("phones", BEAM)]).replace("<exists>\n1\n", f"<exists>\n2\n{points}")
    assert read(tmp_path, text).intervals == PHONES
    assert read(tmp_path, text, tier="2").intervals == PHONES


def test_chronological_text(tmp_path: Path) -> None:
    text = '''"Praat chronological TextGrid text file"
    0 1   ! Time domain.
    2   ! Number of tiers.
    "IntervalTier" "phones" 0 1
    "TextTier" "bell" 0 1
    1 0 0.5
    "B"
    2 0.25
    "ding"
    1 0.5 1
    "IY1"'''
    assert [i.label for i in read(tmp_path, text).intervals] == ["B", "IY1"]
    with pytest.raises(AlignmentError, match=r"a.TextGrid: is damaged: an entry belongs to tier 3 of 2"):
        read(tmp_path, text.replace("\n    2 0.25", "\n    3 0.25"))


def test_a_file_cut_out_of_a_longer_one_starts_at_zero(tmp_path: Path) -> None:
    entries: list[Entry] = [(100, 100.5, "B"), (100.5, 101, "IY")]
    found = read(tmp_path, long_text([("phones", entries)], start=100, end=101))
    assert found.offset == 100
    assert found.duration == 1
    assert found.intervals == (Interval("B", 0, 0.5), Interval("IY", 0.5, 1))


def test_a_small_start_is_kept(tmp_path: Path) -> None:
    found = read(tmp_path, long_text([("phones", [(0.0125, 1, "B")])], start=0.0125))
    assert found.offset == 0
    assert found.intervals == (Interval("B", 0.0125, 1),)


def test_rounding_is_mended(tmp_path: Path) -> None:
    entries: list[Entry] = [(0.0000004, 0.5000001, "B"), (0.5, 0.9, "IY"), (0.9004, 1, "M")]
    found = read(tmp_path, long_text([("phones", entries)])).intervals
    assert found == (Interval("B", 0, 0.5000001), Interval("IY", 0.5000001, 0.9), Interval("M", 0.9, 1))


def test_nothing_labelled_for_no_time_is_passed_over(tmp_path: Path) -> None:
    entries: list[Entry] = [(0, 0.5, "B"), (0.5, 0.5, ""), (0.5, 1, "IY")]
    assert len(read(tmp_path, long_text([("phones", entries)])).intervals) == 2


BAD_TIMES: list[tuple[list[Entry], str]] = [
    ([(0, 0.6, "B"), (0.2, 1, "IY")], r'interval 2 "IY" from 0.2 to 1 s: overlaps the one before it'),
    ([(0, 0.5, "B"), (0.7, 0.6, "IY")], r'interval 2 "IY" from 0.7 to 0.6 s: ends before it starts'),
    ([(0, "nan", "B")], r'interval 1 "B" from 0 to nan s: its time is not a number'),
    ([(0, 0.5, "B"), ("inf", "inf", "IY")], r'interval 2 "IY" from inf to inf s: its time is not a number'),
    ([(-0.5, 0.5, "B")], r'interval 1 "B" from -0.5 to 0.5 s: starts before the file'),
]


@pytest.mark.parametrize(("entries", "message"), BAD_TIMES)
@pytest.mark.parametrize("write", [long_text, short_text])
def test_times_that_make_no_sense(tmp_path: Path, write, entries: list[Entry], message: str) -> None:
    with pytest.raises(AlignmentError, match=rf'a.TextGrid: tier "phones", {message}') as error:
        read(tmp_path, write([("phones", entries)]))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("start", "end", "message"),
    [
        (0, 6 * 3600, r"is 6.0 hours long, over the limit of 2; split it"),
        (0, 0, r"has no duration; align the recording again"),
        (-3, 1, r"starts at -3 s, before 0; shift its times to zero"),
        (0, float("nan"), r"starts at 0.0 s and ends at nan s; correct its header"),
    ],
)
def test_headers_that_make_no_sense(tmp_path: Path, start: float, end: float, message: str) -> None:
    entries: list[Entry] = [] if end == 0 else [(0, 1, "B")]
    with pytest.raises(AlignmentError, match=rf"a.TextGrid: {message}"):
        read(tmp_path, long_text([("phones", entries)], start=start, end=end))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"TextGrid"', '"PitchTier"', r'contains a Praat object of class "PitchTier", not a TextGrid'),
        ("0.3\n0.5\n", "0.3\n", r'tier 2 "phones", entry 3 of 5: .* is found where a number is expected'),
        ('0.6\n1\n"sil"\n', "", r'tier 2 "phones", entry 5 of 5: the file ends where a number is expected'),
        ('"M"', "M", r'tier 2 "phones", entry 4 of 5: "0.6" is found where a text in quotes is expected'),
        ("1\n5\n", "1\n-5\n", r"tier 2: the count is -5; the file is truncated or damaged"),
        ("<exists>", "", r'header: "2.0" is found where <exists> is expected'),
    ],
)
def test_damaged_files(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = short_text(TIERS)
    assert old in text
    with pytest.raises(AlignmentError, match=rf"a.TextGrid: {message}"):
        read(tmp_path, text.replace(old, new))


def test_a_grid_without_tiers(tmp_path: Path) -> None:
    with pytest.raises(AlignmentError, match=r"a.TextGrid: has no interval tier; align the recording first"):
        read(tmp_path, short_text([]).replace("<exists>\n0\n", "<absent>\n"))
