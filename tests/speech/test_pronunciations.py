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


def test_a_missing_word_that_cannot_be_spelled_is_named(tmp_path: Path) -> None:
    dictionary = save(tmp_path, "me M IY\n", name="d.txt")
    words = [(0.2, 0.6, "жук")]
    with pytest.raises(
        AlignmentError,
        match=r'a.TextGrid: word "жук" at 0.20 s is not in .*d.txt; add it there, or leave it out',
    ):
        read_alignment(save(tmp_path, long_text([("words", words)])), lexicon=dictionary)


def read_words(
    folder: Path, *words: str, lexicon: str = CMU, **options: str
) -> tuple[list[str], tuple[str, ...]]:
    """The phones of words of 0.4 s each, and the notes."""
    said = [{"word": word, "start": 0.4 * n, "end": 0.4 * n + 0.4} for n, word in enumerate(words)]
    path = save(folder, json.dumps({"result": said}), name="x.json")
    alignment = read_alignment(path, lexicon=save(folder, lexicon, name="d.txt"), **options)
    return [one.label for one in alignment.intervals], alignment.notes


def test_what_happens_to_words_that_cannot_be_spelled(tmp_path: Path) -> None:
    other = "haus h aʊ s\nbaum b aʊ m\n"
    assert read_words(tmp_path, "Hauz", lexicon=other, unknown="nearest") == (
        ["h", "aʊ", "s"],
        (NOTE, "are not in d.txt, and are shown as 'haus': hauz"),
    )
    phones, notes = read_words(tmp_path, "Baum", "xyz", lexicon=other, unknown="silence")
    assert phones == ["b", "aʊ", "m", "sil"]
    assert notes == (NOTE, "are not in d.txt, and are shown as silence: xyz")


@pytest.mark.parametrize(
    ("word", "phones"),
    [
        ("Beam\u2019s", "B IY1 M Z"),
        ("me-beam", "M IY1 B IY1 M"),
        ("\u201cbeam\u201d,", "B IY1 M"),
        ("beam\u2014me", "B IY1 M M IY1"),
        ("\u2581beam", "B IY1 M"),
        ("Beam.", "B IY1 M"),
        ("UFO", "Y UW EH F OW"),
        ("ship", "SH IH P"),
        ("ph\u00f4ne", "F OW N"),
        ("hmm", "EY CH EH M EH M"),
    ],
)
def test_words_as_transcripts_write_them(tmp_path: Path, word: str, phones: str) -> None:
    assert read_words(tmp_path, word)[0] == phones.split()


def test_sounds_in_brackets_are_silence(tmp_path: Path) -> None:
    phones, notes = read_words(tmp_path, "beam", "(door slams)", "\u266a", "me")
    assert phones == ["B", "IY1", "M", "M", "IY1"]
    assert notes == (NOTE, "are sounds, shown as silence: (door slams), \u266a")


def test_spelled_words_are_told(tmp_path: Path) -> None:
    assert read_words(tmp_path, "beam", "ship", "ships")[1] == (
        NOTE,
        "are not in d.txt, and are spelled by their letters: ship, ships",
    )


def test_without_a_dictionary_english_is_looked_up_where_one_is_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed = save(tmp_path, CMU, name="cmu.dict")
    monkeypatch.setattr("phonanim.speech.pronunciations.find_cmu_dictionary", lambda: installed)
    monkeypatch.setattr("phonanim.speech.ruled_words.can_speak", lambda: False)
    path = save(tmp_path, long_text([("words", WORDS)]))
    assert [i.label for i in read_alignment(path).intervals] == ["", "B", "IY1", "M", ""]
    with pytest.raises(AlignmentError, match="has words but no phones"):
        read_alignment(path, language="german")
    german = {"language": "de", "segments": [{"words": [{"word": "beam", "start": 0, "end": 1}]}]}
    with pytest.raises(AlignmentError, match="has words but no phones"):
        read_alignment(save(tmp_path, json.dumps(german), name="x.json"))
    foreign = [(0.0, 0.5, "guten"), (0.5, 1.0, "abend")]
    with pytest.raises(AlignmentError, match="has words but no phones"):
        read_alignment(save(tmp_path, long_text([("words", foreign)])))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (None, r"d.txt: cannot be read: No such file"),
        (b"\xff\xfe\xff", r"d.txt: cannot be read: it is not UTF-8 text"),
        (b"\n;;; nothing\n", r"d.txt: has no line of a word and its phones; name a pronunciation dictionary"),
    ],
)
def test_dictionaries_that_are_none(tmp_path: Path, data: bytes | None, message: str) -> None:
    path = tmp_path / "d.txt"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(AlignmentError, match=message):
        load_pronunciations(path)
