"""How sure the words of an alignment are."""

from __future__ import annotations

import json
import wave
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from phonanim.aligners.confidence import SPEECH, _apart, _sound, judge, with_confidence
from phonanim.aligners.long import align_recording
from phonanim.aligners.pocketsphinx import SpeechAlignment, align
from phonanim.commands.align import command
from phonanim.errors import PhonanimError
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import read_sound
from phonanim.speech.alignment import Interval
from phonanim.speech.doubts import DOUBTFUL, doubtful_time

SAID = "they bought their offices from one another and were thus considered to have a vested interest in them"
LINE = "My father watched Bob move a cheap blue lamp from the wash room."


@pytest.fixture
def recording(shared_data: Path) -> Path:
    pytest.importorskip("pocketsphinx")
    return shared_data / "textgrids" / "002_en_LJ006-0114.wav"


def sure(recording: Path, text: str) -> SpeechAlignment:
    return with_confidence(align(recording, text), recording, "english")


def test_the_right_text_is_sure(recording: Path) -> None:
    found = sure(recording, SAID)
    assert [(one.start, one.end) for one in found.confidence] == [(w.start, w.end) for w in found.words]
    assert min(float(one.label) for one in found.confidence) >= DOUBTFUL
    assert np.mean([float(one.label) for one in found.confidence]) > 0.85
    assert found.notes == ()


def test_exchanged_words_are_doubtful(recording: Path) -> None:
    found = sure(recording, SAID.replace("thus considered", "never expected"))
    low = {
        w.label for w, one in zip(found.words, found.confidence, strict=True) if float(one.label) < DOUBTFUL
    }
    assert {"never", "expected"} <= low <= {"were", "never", "expected", "to"}
    assert found.notes[-1].startswith("doubtful, check the text there: 2.5 to 3.4 s ('were never expected'")


def test_words_beside_what_the_text_lacks_are_doubtful(recording: Path) -> None:
    found = sure(recording, SAID.replace("from one another ", ""))
    assert "('and" in found.notes[-1]


def test_sound_without_words_is_told(root: Path) -> None:
    pytest.importorskip("pocketsphinx")
    line = root / "examples/line.wav"
    found = sure(line, LINE.replace(" a cheap blue lamp", ""))
    (gap,) = [one for one in found.confidence if one.label == "0.00"]
    assert (gap.start, gap.end) == pytest.approx((1.9, 3.1), abs=0.15)
    assert "(sound without words of the text)" in found.notes[-1]
    assert not [one for one in sure(line, LINE).confidence if one.label == "0.00"]


def test_sound_never_overlaps_a_word() -> None:
    words = [Interval("a", 0.1234, 0.2526), Interval("b", 0.8014, 0.9)]
    (_, between, _) = _sound(np.ones(120, bool), words)
    assert words[0].end <= between[0] < between[1] <= words[1].start
    assert between[1] - between[0] > 0.5


def test_sound_is_apart_from_words_of_another_window() -> None:
    words = [Interval("a", 0.0, 1.0), Interval("b", 2.0, 3.0)]
    told = [Interval("0.90", 0.0, 1.0), Interval("0.00", 0.8, 2.2), Interval("0.90", 2.0, 3.0)]
    assert list(_apart(told, words)) == [told[0], Interval("0.00", 1.0, 2.0), told[2]]
    assert list(_apart([told[0], Interval("0.00", 0.9, 1.1)], words)) == [told[0]]


def test_sound_ends_with_the_recording() -> None:
    chance = np.random.default_rng(0)
    samples = chance.normal(0, 0.1, 16_099).astype(np.float32)
    sound = judge(samples, [Interval("a", 0.1, 0.2)], [Interval("AH", 0.1, 0.2)], "english").sound
    assert sound.max() <= 16_099 / 16_000


def test_silence_is_no_sound(root: Path) -> None:
    pytest.importorskip("pocketsphinx")
    sound = read_sound(root / "examples/line.wav")
    found = align(root / "examples/line.wav", LINE)
    silence = np.zeros(3 * sound.rate, np.float32)
    later = [Interval(w.label, w.start + 3, w.end + 3) for w in found.words]
    phones = [Interval(p.label, p.start + 3, p.end + 3) for p in found.phones]
    from phonanim.media.audio import resample

    samples = resample(np.concatenate([silence, sound.samples, silence]), sound.rate, 16000)
    assert judge(samples, later, phones, "english").gaps.max() < SPEECH


def test_a_phrase_that_the_text_lacks_is_found_by_the_recognized_words(recording: Path) -> None:
    pytest.importorskip("ctranslate2", reason="needs the extra recognize")
    found, _ = align_recording(recording, SAID.replace("from one another ", ""), None)
    assert " ".join(word.label for word in found.words) == SAID
    assert found.notes[0].startswith(
        "parts of the text do not fit the audio; aligned by the words recognized"
    )
    assert doubtful_time(found.confidence) < 0.3


def test_without_the_recognizer_the_phrase_is_flagged(
    recording: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("phonanim.aligners.long.can_recognize", lambda: False)
    found, _ = align_recording(recording, SAID.replace("from one another ", ""), None)
    assert doubtful_time(found.confidence) > 0.8
    assert "doubtful, check the text there: " in found.notes[-1]


def test_other_languages(shared_data: Path) -> None:
    pytest.importorskip("espeakng_loader", reason="needs the extra espeak")
    path = shared_data / "ema_de" / "dfgspp_mo1_prosody_0020.wav"
    found, _ = align_recording(path, "Sie arbeitet in einer Kneipe als Kellnerin.", "de")
    assert len(found.confidence) >= len(found.words)
    wrong, _ = align_recording(path, "Gestern flogen viele bunte Vögel nach Süden.", "de")
    levels = [np.mean([float(one.label) for one in each.confidence]) for each in (found, wrong)]
    assert levels[0] > levels[1] + 0.2


def test_the_confidence_is_written_and_read(root: Path, tmp_path: Path) -> None:
    pytest.importorskip("pocketsphinx")
    text = LINE.replace("cheap blue lamp", "green wooden table")
    arguments = [
        str(root / "examples/line.wav"),
        "--text",
        text,
        "-o",
        str(tmp_path / "a.TextGrid"),
        "--json",
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("phonanim.aligners.long.can_recognize", lambda: False)
        patch.setattr("phonanim.aligners.long.can_speak", lambda: False)
        done = CliRunner().invoke(command, arguments)
    if done.exit_code:  # the words cannot be found at all, which is told as well
        assert isinstance(done.exception, PhonanimError)
        return
    facts = json.loads(done.stdout)
    assert len(facts["confidence"]) >= 13
    assert facts["notes"][-1].startswith("doubtful, check the text there: ")
    assert read_alignment(tmp_path / "a.TextGrid").notes[-1] == facts["notes"][-1]


def test_a_word_without_sound(tmp_path: Path) -> None:
    path = tmp_path / "noise.wav"
    with wave.open(str(path), "wb") as stream:
        stream.setparams((1, 2, 16000, 0, "NONE", ""))
        noise = np.random.default_rng(0).normal(0, 300, 16000)
        stream.writeframes(noise.astype("<i2").tobytes())
    word, phone = Interval("a", 0.4, 0.41), Interval("AH", 0.4, 0.41)
    found = with_confidence(SpeechAlignment((word,), (phone,), 1.0), path, "english")
    assert 0.0 <= float(found.confidence[-1].label) <= 1.0
