"""Labels in the letters of a script are read, or the package that reads them is named."""

from __future__ import annotations

import importlib.util
import sys
import types

import pytest

from phonanim.errors import LabelError
from phonanim.speech import letters
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.bilabials import says_shut, shut_segments
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.language import read_phones
from phonanim.speech.language_files import load_language
from phonanim.speech.letters import script_languages, script_of, spell_hangul, spell_kana
from phonanim.speech.phones import PhoneTrack

INSTALLED = importlib.util.find_spec("epitran") is not None


def line(labels: str) -> Alignment:
    """An alignment of labels of a tenth of a second."""
    parts = labels.split()
    intervals = tuple(Interval(label, 0.1 * n, 0.1 * (n + 1)) for n, label in enumerate(parts))
    return Alignment(intervals, 0.1 * len(parts), "phones", "a.TextGrid")


@pytest.mark.parametrize(
    ("kana", "labels"),
    [
        ("か", "k a"),
        ("しゃ", "sh a"),
        ("キョ", "ky o"),
        ("ふ", "f u"),
        ("ファ", "f a"),
        ("つ", "ts u"),
        ("っ", "cl"),
        ("ん", "N"),
        ("カー", "k a:"),
        ("あ", "a"),
    ],
)
def test_kana_are_the_labels_of_japanese(kana: str, labels: str) -> None:
    assert spell_kana(kana) == tuple(labels.split())
    assert load_language("japanese").resolve(kana)


def test_hangul_syllables_are_their_letters() -> None:
    assert spell_hangul("밥") == ("ㅂ", "ㅏ", "ㅂ")
    assert spell_hangul("아") == ("ㅏ",)
    track = read_phones(line("밥 몸")).track
    assert [INVENTORY.phones[code] for code in track.codes] == ["p", "aa", "p", "m", "ow", "m"]


@pytest.mark.parametrize(
    ("letters", "language"),
    [("ま み", "japanese"), ("м ы", "russian"), ("м і", "ukrainian"), ("ม า", "thai"), ("م ا", "arabic")],
)
def test_a_script_tells_the_language(letters: str, language: str) -> None:
    found = script_languages(letters.split())
    assert max(found, key=lambda name: found[name]) == language
    assert sum(found.values()) == pytest.approx(1)
    assert script_languages(["m", "a"]) == {}
    assert script_of("θ") == script_of("β") == ""  # IPA


@pytest.mark.skipif(INSTALLED, reason="epitran is installed")
def test_the_package_that_reads_a_script_is_named() -> None:
    with pytest.raises(LabelError, match=r"Cyrillic letters are read with pip install 'phonanim\[letters\]'"):
        read_phones(line("м ы"))


@pytest.mark.skipif(not INSTALLED, reason="needs epitran")
def test_letters_are_read_by_their_mapping() -> None:
    track = read_phones(line("м ы ш")).track
    assert [INVENTORY.phones[code] for code in track.codes] == ["m", "ih", "sh"]


def test_letters_go_to_the_mapping_of_their_language(monkeypatch: pytest.MonkeyPatch) -> None:
    class Epitran:
        def __init__(self, mapping: str) -> None:
            self.mapping = mapping

        def transliterate(self, label: str) -> str:
            return {"rus-Cyrl": {"м": "m", "ы": "ɨ"}, "hin-Deva": {"म": "mə"}}[self.mapping][label]

    caches = (letters._transliterator, letters.spell_letters)
    monkeypatch.setattr(letters, "find_spec", lambda name: object())
    monkeypatch.setitem(sys.modules, "epitran", types.SimpleNamespace(Epitran=Epitran))
    for cache in caches:
        cache.cache_clear()
    try:
        assert letters.spell_letters("м", "russian") == ("m",)
        assert letters.spell_letters("ы", "russian") == ("ɨ",)
        assert letters.spell_letters("म", "hindi") == ("m",)  # without the vowel that its name has
        assert letters.spell_letters("м", "bulgarian") == ()
        assert letters.needs_package("м") == ""
        assert letters.needs_package("γ") == "Greek letters are not read; give phones in IPA"
    finally:
        for cache in caches:
            cache.cache_clear()


def test_labels_say_that_lips_shut() -> None:
    for label in ("m", "P", "bʲ", "ま", "ㅂ", "м", "พ", "mb"):
        assert says_shut(label), label
    for label in ("", "pau", "sp", "t", "f", "p\\", "か"):
        assert not says_shut(label), label
    assert not says_shut("ph", load_language("vietnamese"))
    assert not says_shut("B", load_language("spanish"))  # SAMPA of Spanish: [β]
    assert says_shut("B", load_language("polish"))


def test_a_label_of_shut_lips_counts_whatever_it_was_read_as() -> None:
    codes = INVENTORY.codes(["sil", "uh", "aa", "m", "t", "s"])
    track = PhoneTrack(codes, INVENTORY.codes(["sil"] * 7) * 0.1, ("", "M", "a", "m", "pt", "pt"))
    assert shut_segments(track, load_language("turkish")) == [3, 4]
    assert shut_segments(track, load_language("german")) == [1, 3, 4]


@pytest.mark.parametrize(
    ("language", "labels", "phones"),
    [
        ("fr", "M e P E R D y P O M", "m ey p eh hh d uw p ao m"),
        ("es", "m u ch o", "m uw ch ow"),
        ("eu", "e tx e tz", "ey ch ey t s"),
        ("ko", "s eo u l", "s ah uw l"),
        ("ko", "eu m", "ih m"),
        ("de", "B A M", "b aa m"),
        ("tr", "M P", "ih p"),  # SAMPA of Turkish lists M
    ],
)
def test_a_named_language_reads_its_own_labels(language: str, labels: str, phones: str) -> None:
    track = read_phones(line(labels), language).track
    assert [INVENTORY.phones[code] for code in track.codes] == phones.split()


def test_a_label_of_another_alphabet_is_noted() -> None:
    notes = read_phones(line("a b_< a"), "fr").notes
    assert notes == ('"b_<" at 0.10 s: no label of french, read as X-SAMPA',)
    assert read_phones(line("i a~ E:"), "fr").notes == ()
