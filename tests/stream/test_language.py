"""The language of a stream is found by its first labels, told once, and kept."""

from __future__ import annotations

import pytest

from phonanim.errors import LabelError
from phonanim.options import Options
from phonanim.stream.engine import PhoneStream
from phonanim.stream.language import FEWEST, MOST, StreamedLanguage

FRENCH = ["b", "ɔ̃", "ʒ", "u", "ʁ", "s", "a", "l", "y", "m", "a"]


def push(stream: PhoneStream, labels: list[str]) -> None:
    for number, label in enumerate(labels):
        stream.push(label, number * 0.1, number * 0.1 + 0.1)


def test_the_language_is_told_once_when_it_is_settled() -> None:
    stream = PhoneStream(Options(life=0), None)
    told = []
    for number, label in enumerate(FRENCH):
        stream.push(label, number * 0.1, number * 0.1 + 0.1)
        told.append(stream.news())
    assert [number for number, text in enumerate(told) if text] == [FEWEST - 1]
    assert told[FEWEST - 1] == "language french, by the first 8 labels, 99 % sure"
    assert stream.options.language == "french"
    assert stream.notes == ()


def test_a_short_stream_says_at_its_end_what_it_was_read_as() -> None:
    stream = PhoneStream(Options(life=0), None)
    push(stream, ["y", "r"])
    assert stream.news() == ""
    decided, doubt = stream.notes
    assert "by the first 2 labels" in decided
    assert doubt.startswith("the language is unsure: ")


def test_a_settled_language_stays() -> None:
    language = StreamedLanguage("auto")
    for label in FRENCH:
        language.add(label)
    for label in ("HH", "AH", "L", "OW") * MOST:
        assert language.add(label) == "french"


@pytest.mark.parametrize(("asked", "name"), [("auto:ja", "japanese"), ("ja", "ja"), ("german", "german")])
def test_languages_that_are_named_or_expected(asked: str, name: str) -> None:
    language = StreamedLanguage(asked)
    assert [language.add(label) for label in "yama"][-1] == name


def test_a_label_that_no_language_has_does_not_decide() -> None:
    stream = PhoneStream(Options(life=0), None)
    push(stream, FRENCH[:5])
    with pytest.raises(LabelError, match="§§"):
        stream.push("§§", 0.5, 0.6)
    assert stream.language.labels == FRENCH[:5]
    assert stream.options.language == "french"


def test_romanized_and_ipa_letters_of_one_language() -> None:
    language = StreamedLanguage("auto")
    assert [language.add(label) for label in ["k", "oː", "j", "a", "ɴ"]][-1] == "japanese:ipa"
