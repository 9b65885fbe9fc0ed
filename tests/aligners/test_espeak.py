from __future__ import annotations

import wave
from pathlib import Path
from unicodedata import normalize

import numpy as np
import pytest

pytest.importorskip("espeakng_loader", reason="needs the extra espeak")

from phonanim.aligners.espeak import MARGIN, reading_language, speak, write_speech
from phonanim.errors import OptionError
from phonanim.speech.alignment import Alignment
from phonanim.speech.ipa import parse_ipa
from phonanim.speech.language import to_phones


def test_words_and_phones_have_their_times() -> None:
    spoken = speak("My father moved. Bob!")
    assert [word.label for word in spoken.words] == ["My", "father", "moved", "Bob"]
    assert spoken.phones[0].label == "m"
    assert spoken.phones[0].start == pytest.approx(MARGIN, abs=0.02)
    assert spoken.phones[-1].end <= spoken.duration - MARGIN + 1e-9
    assert all(a.end <= b.start + 1e-9 for a, b in zip(spoken.phones, spoken.phones[1:], strict=False))
    bob = spoken.words[-1]
    assert [phone.label for phone in spoken.phones if bob.start <= phone.start < bob.end][::2] == ["b", "b"]


def test_sound_is_there_where_phones_are() -> None:
    spoken = speak("A sharp saw.")
    level = np.abs(spoken.samples.astype(float))
    begin, end = (round(t * spoken.rate) for t in (spoken.phones[0].start, spoken.phones[-1].end))
    assert level[begin:end].mean() > 300
    assert level[: round(0.9 * MARGIN * spoken.rate)].max() < 50


def test_a_number_is_one_word() -> None:
    assert [word.label for word in speak("Take 21 worlds").words] == ["Take", "21", "worlds"]


@pytest.mark.parametrize(
    ("voice", "text", "has"),
    [("de", "Über Königs Tür", "y"), ("fr", "tu bois", "b"), ("ja", "ママ", "m"), ("german", "Tür", "y")],
)
def test_languages(voice: str, text: str, has: str) -> None:
    labels = [phone.label for phone in speak(text, voice).phones]
    assert any(has in label for label in labels)
    assert all(parse_ipa(label) for label in labels)


def test_names_of_its_own_are_ipa() -> None:
    assert [phone.label for phone in speak("中", "cmn").phones] == ["ʈʂ", "ˈʊ", "ŋ"]
    assert "ɧ" in [phone.label for phone in speak("sju", "sv").phones]
    assert speak("faci", "ro").phones[-1].label == "tʃʲ"
    assert reading_language("ja") == "japanese:ipa"
    assert (reading_language("pt-br"), reading_language("ca")) == ("portuguese", "ipa")


@pytest.mark.parametrize(
    ("text", "voice"),
    [("I like it", "de"), ("tout le monde", "fr"), ("hun er ung", "da"), ("문이 있다", "ko")],
)
def test_the_phones_of_a_voice_are_those_of_its_language(text: str, voice: str) -> None:
    spoken = speak(text, voice)
    track, _ = to_phones(Alignment(spoken.phones, spoken.duration, "", text), reading_language(voice))
    assert len(track.codes) >= len(text.split())


def test_signs_of_two_parts_are_read_as_one() -> None:
    whole, parted = (speak(normalize(form, "được tự do"), "vi").phones for form in ("NFC", "NFD"))
    assert whole == parted


def test_a_voice_that_cannot_read_the_script_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("phonanim.speech.spoken_text.can_read", lambda text: False)
    told = r"the voice ja cannot read 人権です; pip install 'phonanim\[ja\]' reads kanji, or write it in kana"
    with pytest.raises(OptionError, match=told):
        speak("人権です", "ja")


def test_a_voice_by_the_name_of_its_language() -> None:
    assert [phone.label for phone in speak("你好", "mandarin").phones] == ["n", "i", "χ", "ˈɑu"]


def test_speech_marked_up_and_what_is_not_said() -> None:
    marked = speak('<speak>Hi <break time="700ms"/> <emphasis>Bob</emphasis></speak>')
    assert [word.label for word in marked.words] == ["Hi", "Bob"]
    assert marked.words[1].start - marked.words[0].end > 0.6
    spoken = speak("[laughs] Shh! B-but Bob 😀 (sighs)")
    assert [word.label for word in spoken.words] == ["Shh", "Buh", "but", "Bob"]
    assert spoken.phones[0].label == "ʃ"
    assert spoken.notes == ("directions, not spoken: [laughs] (sighs)", "signs, not spoken: 😀")


def test_the_rate_of_speech() -> None:
    assert (
        speak("One two three four.", words_per_minute=120).duration
        > 1.2 * speak("One two three four.").duration
    )


def test_the_same_text_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_speech(tmp_path / f"{name}.wav", speak("Again and again."))
    assert (tmp_path / "a.wav").read_bytes() == (tmp_path / "b.wav").read_bytes()
    with wave.open(str(tmp_path / "a.wav")) as stream:
        assert stream.getframerate() == speak("Again.").rate


def test_a_voice_that_is_not_there_and_nothing_to_say() -> None:
    with pytest.raises(OptionError, match="no voice 'germann'; did you mean 'german'"):
        speak("Hallo", "germann")
    for text in ("", "..."):
        with pytest.raises(OptionError, match="the text has no words"):
            speak(text)
