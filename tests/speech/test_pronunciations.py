"""Words with times and a dictionary become phones; a word that is missing is named."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from textgrid_text import BEAM, WORDS, long_text, save

from phonanim.errors import AlignmentError
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.pronunciations import NOTE, load_pronunciations

CMU = ";;; comment\nBEAM  B IY1 M\nBEAM(2)  B IH1 M\nME  M IY1\n"
MFA = "beam\t0.99\t0.05\t1.0\t1.0\tb iː m\nme\tm i\n"


@pytest.mark.parametrize(("text", "expected"), [(CMU, ("B", "IY1", "M")), (MFA, ("b", "iː", "m"))])
def test_dictionaries_of_cmu_and_mfa(tmp_path: Path, text: str, expected: tuple[str, ...]) -> None:
    words = load_pronunciations(save(tmp_path, text, name="d.txt"))
    assert words["beam"] == expected
    assert set(words) == {"beam", "me"}


def test_words_of_a_recognizer_are_spelled_out(tmp_path: Path) -> None:
    dictionary = save(tmp_path, CMU, name="d.txt")
    said = [{"word": "Beam,", "start": 0.3, "end": 0.6}, {"word": "me!", "start": 0.6, "end": 1.0}]
    alignment = read_alignment(
        save(tmp_path, json.dumps({"result": said}), name="x.json"), lexicon=dictionary
    )
    assert [(i.label, round(i.start, 6), round(i.end, 6)) for i in alignment.intervals] == [
        ("B", 0.3, 0.4),
        ("IY1", 0.4, 0.5),
        ("M", 0.5, 0.6),
        ("M", 0.6, 0.8),
        ("IY1", 0.8, 1.0),
    ]
    assert [word.label for word in alignment.words] == ["Beam,", "me!"]
    assert alignment.notes == (NOTE,)


def test_silences_between_words_stay(tmp_path: Path) -> None:
    dictionary = save(tmp_path, CMU, name="d.txt")
    alignment = read_alignment(save(tmp_path, long_text([("words", WORDS)])), lexicon=dictionary)
    assert [interval.label for interval in alignment.intervals] == ["", "B", "IY1", "M", ""]


def test_phones_of_an_aligner_go_before_a_dictionary(tmp_path: Path) -> None:
    path = save(tmp_path, long_text([("words", WORDS), ("phones", BEAM)]))
    alignment = read_alignment(path, lexicon=tmp_path / "absent")
    assert len(alignment.intervals) == len(BEAM)
    assert alignment.notes == ()


def test_a_missing_word_is_named(tmp_path: Path) -> None:
    dictionary = save(tmp_path, "me M IY\n", name="d.txt")
    with pytest.raises(
        AlignmentError, match=r'a.TextGrid: word "beam" at 0.20 s is not in .*d.txt; add it there'
    ):
        read_alignment(save(tmp_path, long_text([("words", WORDS)])), lexicon=dictionary)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (None, r"d.txt: cannot be read: No such file"),
        (b"\xff\xfe\xff", r"d.txt: cannot be read: is not UTF-8 text"),
        (b"\n;;; nothing\n", r"d.txt: has no line of a word and its phones; name a pronunciation dictionary"),
    ],
)
def test_dictionaries_that_are_none(tmp_path: Path, data: bytes | None, message: str) -> None:
    path = tmp_path / "d.txt"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(AlignmentError, match=message):
        load_pronunciations(path)
