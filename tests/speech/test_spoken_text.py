"""What a voice is given of a text: marks and directions, amounts, letters that it cannot read, kanji."""

from __future__ import annotations

import importlib.util
from types import SimpleNamespace

import pytest

from phonanim.errors import OptionError
from phonanim.speech import kana
from phonanim.speech.spoken_text import espeak_voice, prepare_text, readable_word, voice_code


@pytest.mark.parametrize(
    ("voice", "text", "spoken"),
    [
        ("en-us", "<i>Stop</i> {\\an8}now", "Stop now"),
        ("en-us", "**Bold** and _quiet_ `x`", "Bold and quiet x"),
        ("en-us", "I (a poodle) *really* bark", "I (a poodle) really bark"),
        (
            "en-us",
            "It costs $1,234.50.",
            "It costs one thousand two hundred thirty four dollars fifty cents.",
        ),
        ("en-us", "On 03/05/2024, 2 * 3", "On 03 05 2024, 2 times 3"),
        ("en-us", "See https://example.com/a/ now", "See example dot com slash a now"),
        ("en-us", "W-what? th-that!", "Wuh what? thuh that!"),
        ("en-us", "Hmm, shhh, mmm", "Hmm, [[S:]], [[m:m:]]"),
        ("en-us", "5 μm of π", "5 μm of π"),
        ("de", "Es kostet 3,50 € (lacht)", "Es kostet 3,50 €"),
        ("de", "Brr, W-was", "Brr, W-was"),
        ("fr", "Oui ♪ la la ♪", "Oui la la"),
        ("he", "שָׁלוֹם", "שלום"),
        ("ru", "Привет, Bob", "Привет, Bob"),
        ("a < b", "a < b and c > d", "a < b and c > d"),
        ("en-us", "ANNA: Hello.\nBOB (whispers): Hush & go.", "Hello. Hush and go."),
        ("de", "Anna: Hallo.\nBob: Ja.", "Hallo. Ja."),
        ("en-us", "He said: no.\nShe went.", "He said: no. She went."),
        ("en-us", "Remember: no.", "Remember: no."),
        ("en-us", "1\n00:00:00,000 --> 00:00:04,000\nHello.\n", "Hello."),
        ("en-us", "At 3:30, 50% left", "At three thirty, 50 percent left"),
    ],
)
def test_what_is_spoken(voice: str, text: str, spoken: str) -> None:
    assert " ".join(prepare_text(text, voice).text.split()) == spoken


def test_what_is_left_out_is_noted() -> None:
    form = prepare_text("ANNA: [a] [b] [c] [d] Hi <b>you</b> 👨‍👩‍👧 👍🏽", "en")
    assert form.notes == (
        "marks, not spoken: <b> </b>",
        "speakers, not spoken: ANNA:",
        "directions, not spoken: [a] [b] [c] and 1 more",
        "signs, not spoken: 👨‍👩‍👧 👍🏽",
    )


@pytest.mark.parametrize("text", ["", " ", "... -- !?", "[music]", "\u266a", "ANNA:"])
def test_a_text_without_words(text: str) -> None:
    with pytest.raises(OptionError, match="the text has no words.*; give the words that are spoken"):
        prepare_text(text, "de")


def test_ssml_is_left_to_the_voice() -> None:
    text = '<speak>Hi <break time="1s"/> Bob</speak>'
    form = prepare_text(text, "en")
    assert (form.text, form.is_ssml) == (text, True)
    with pytest.raises(OptionError, match="the voice en cannot read Привет; name its language"):
        prepare_text("<speak>Привет</speak>", "en")


@pytest.mark.parametrize(
    ("voice", "text", "message"),
    [
        ("en-us", "Привет, Bob", "the voice en-us cannot read Привет; name its language, such as --voice ru"),
        ("de", "今日は", "the voice de cannot read 今日は; name its language, such as --voice cmn or ja"),
        ("en", "สวัสดี", "the voice en cannot read .*--voice th"),
        ("ru", "Ελλάδα", "the voice ru cannot read Ελλάδα; name its language, such as --voice el"),
    ],
)
def test_letters_that_a_voice_would_name_are_refused(voice: str, text: str, message: str) -> None:
    with pytest.raises(OptionError, match=message):
        prepare_text(text, voice)
    assert readable_word(text.split(",")[0], voice) == ""


def test_doubtful_readings_are_noted() -> None:
    vowels = ("vowels that the text does not write are guessed, and some are missing",)
    assert prepare_text("مرحبا كيف حالك", "ar").notes == vowels
    assert prepare_text("مَرْحَبًا", "ar").notes == ()
    assert prepare_text("שלום", "he").notes == vowels
    assert "reads Thai letters wrongly" in prepare_text("สวัสดี", "th").notes[0]


def test_voices_by_name() -> None:
    assert [voice_code(name) for name in ("de+f2", "german", "en-us", "klingon")] == [
        *("de", "de", "en-us", "klingon")
    ]
    assert [espeak_voice(name) for name in ("mandarin", "german+f2", "english", "xx")] == [
        *(voice_code("mandarin"), "de+f2", "english", "xx")
    ]


def test_kanji_are_given_as_kana(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = (("今日", "キョー", 0), ("は", "ワ", 1), ("、", "、", 0), ("買っ", "カッ", 0), ("た", "タ’", 1))
    nodes = [{"string": a, "pron": b, "chain_flag": c} for a, b, c in rows]
    monkeypatch.setattr(kana, "_open_jtalk", lambda: SimpleNamespace(run_frontend=lambda text: nodes))
    monkeypatch.setattr(kana, "find_spec", lambda name: object())
    form = prepare_text("今日は、買った", "ja")
    assert form.text == "キョーワ、 カッタ"
    assert form.written == {"キョーワ": "今日は", "カッタ": "買った"}
    assert readable_word("今日は", "japanese") == "キョーワ、 カッタ"


@pytest.mark.skipif(importlib.util.find_spec("pyopenjtalk") is None, reason="the extra ja")
def test_numbers_and_dates_in_japanese() -> None:
    assert prepare_text("2024年3月5日", "ja").text.replace(" ", "") == "ニセンニジューヨネンサンガツイツカ"
    assert prepare_text("iPhoneを買った", "ja").written["カッタ"] == "買った"
