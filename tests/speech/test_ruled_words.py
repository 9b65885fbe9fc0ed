"""Words of other languages than English are spelled by the rules of eSpeak NG."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from phonanim.errors import AlignmentError
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.espeak_phones import pronounce_words
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.language import read_phones


@pytest.fixture(autouse=True)
def _needs_espeak() -> None:
    pytest.importorskip("espeakng_loader", reason="needs the extra espeak")


def words_file(folder: Path, language: str, *words: str) -> Path:
    content = [{"word": word, "start": 0.5 * n, "end": 0.5 * n + 0.4} for n, word in enumerate(words)]
    path = folder / "x.json"
    path.write_text(json.dumps({"segments": [{"words": content}], "language": language}), "utf-8")
    return path


@pytest.mark.parametrize(
    ("language", "words", "phones"),
    [
        ("de", ("Guten", "Tag,", "21"), "g uw t ah n t aa k ay n uh n t t s v aa n t s ih y"),
        ("fr", ("bonjour", "l’été"), "b ao zh uw hh l ey t ey"),
        ("ja", ("ママ",), "m aa m aa"),
        ("zh", ("中国",), "ch uh ng k uw ow"),
    ],
)
def test_words_numbers_and_scripts(
    tmp_path: Path, language: str, words: tuple[str, ...], phones: str
) -> None:
    alignment = read_alignment(words_file(tmp_path, language, *words))
    assert f"the phones are those of eSpeak NG for {language} and share the time" in alignment.notes[-1]
    reading = read_phones(alignment)
    spoken = [INVENTORY.phones[code] for code in reading.track.codes if code]
    assert spoken == phones.split()
    assert reading.notes == alignment.notes


def test_sounds_are_silent_and_words_keep_their_times(tmp_path: Path) -> None:
    alignment = read_alignment(words_file(tmp_path, "de", "[Musik]", "ja"))
    assert alignment.intervals[0].start == 0.5
    assert "are sounds, shown as silence: [Musik]" in alignment.notes


def test_kanji_are_not_read_as_english(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("phonanim.speech.spoken_text.can_read", lambda text: False)
    with pytest.raises(
        AlignmentError, match='word "東京" at 0.00 s is not read by eSpeak NG for ja; give --lex'
    ):
        read_alignment(words_file(tmp_path, "ja", "東京"))
    left = read_alignment(words_file(tmp_path, "ja", "東京", "ママ"), unknown="silence")
    assert "are not read, and are silence: 東京" in left.notes


def test_a_word_that_a_dictionary_lacks(tmp_path: Path) -> None:
    (tmp_path / "d.dict").write_text("guten ɡ uː t ə n\n", "utf-8")
    alignment = read_alignment(words_file(tmp_path, "de", "guten", "Tag"), lexicon=tmp_path / "d.dict")
    assert [one.label for one in alignment.intervals][-3:] == ["t", "ˈɑː", "k"]
    assert "are not in d.dict, and are pronounced by eSpeak NG: tag" in alignment.notes


def test_the_option_names_the_language(tmp_path: Path) -> None:
    path = tmp_path / "x.srt"
    path.write_text("1\n00:00:00,000 --> 00:00:01,000\nGuten Tag\n")
    assert read_alignment(path, language="german").language == "german"
    with pytest.raises(AlignmentError, match="words of another language than English are read with its name"):
        path.write_text("1\n00:00:00,000 --> 00:00:01,000\nSchöne Grüße übrigens\n")
        read_alignment(path)


def test_without_the_extra_one_line_says_what_brings_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("phonanim.speech.ruled_words.can_speak", lambda: False)
    monkeypatch.setattr("phonanim.media.espeak.can_speak", lambda: False)
    with pytest.raises(AlignmentError, match=r"pip install 'phonanim\[espeak\]' brings pronunciations"):
        read_alignment(words_file(tmp_path, "de", "Guten"))


def test_dates_and_abbreviations() -> None:
    spoken = pronounce_words(["z.B.", "12.03.2024", "%"], "de")
    assert spoken["z.B."][:2] == ("ts", "ˌɛ")
    assert len(spoken["12.03.2024"]) > 30
    assert spoken["%"][0] == "p"
