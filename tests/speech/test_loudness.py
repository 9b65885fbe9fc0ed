"""The slow level of speech: what moves it, and what does not."""

from __future__ import annotations

import numpy as np
import pytest
from voices import RATE, SPOKEN, TIMES, TRACK, voiced, whispered

from phonanim.media.voice import Voice, analyze_voice
from phonanim.speech.loudness import LIMIT, measure_loudness, speech_level


def voice_of(sound: np.ndarray) -> Voice:
    return analyze_voice(sound.astype(np.float32), RATE)


def decibels(sound: np.ndarray, reference: float | None = None) -> np.ndarray:
    return measure_loudness(voice_of(sound), TRACK, reference).at(np.arange(1, 6, 0.1))


def test_steady_speech_is_as_loud_as_usual() -> None:
    assert np.abs(decibels(voiced())).max() < 0.3


def test_a_louder_phrase_is_louder_and_slowly_so() -> None:
    louder = np.where(TIMES > 3.5, 2.0, 1.0)  # 6 dB
    found = measure_loudness(voice_of(voiced() * louder), TRACK)
    ends = found.at(np.array([1.0, 6.0]))
    assert ends[1] - ends[0] == pytest.approx(6.0, abs=0.7)
    assert np.abs(np.diff(found.decibels)).max() * 100 < 8.0  # dB a second: no leap


def test_the_gain_of_the_recording_changes_nothing() -> None:
    sound = voiced() * np.where(TIMES > 3.5, 2.0, 1.0)
    np.testing.assert_allclose(decibels(sound), decibels(0.1 * sound), atol=0.15)


def test_levels_are_bounded() -> None:
    found = decibels(voiced() * np.where(TIMES > 5.5, 20.0, 1.0))
    assert np.abs(found).max() == LIMIT


def test_single_phones_do_not_drive_it() -> None:
    loud = np.where((TIMES > 3.0) & (TIMES < 3.1), 2.0, 1.0)
    assert np.abs(decibels(voiced() * loud)).max() < 1.0


def test_noise_and_music_do_not_drive_it() -> None:
    rng = np.random.default_rng(1)
    noise = 0.05 * rng.normal(size=len(TIMES)) * (TIMES > 3.5)
    assert np.abs(decibels(voiced() + noise)).max() < 1.5
    music = 0.5 * np.sin(2 * np.pi * 220 * TIMES) * np.linspace(0.5, 1, len(TIMES))  # louder than the speech
    assert not decibels(music).any()
    silent = 0.3 * np.sin(2 * np.pi * 220 * TIMES) * ~SPOKEN
    np.testing.assert_allclose(decibels(voiced() + silent), decibels(voiced()), atol=0.5)


def test_a_whisper_is_no_smaller() -> None:
    found = measure_loudness(voice_of(whispered()), TRACK, reference=-20.0)
    assert found.whispered
    assert np.isnan(found.mean)
    assert not found.decibels.any()


def test_a_voice_far_away_is_no_whisper() -> None:
    found = measure_loudness(voice_of(0.05 * voiced()), TRACK)
    assert not found.whispered
    assert found.mean == pytest.approx(-46, abs=2)


def test_whispered_words_in_a_line_are_no_smaller() -> None:
    mixed = np.where(TIMES > 3.5, whispered(), voiced())
    found = decibels(mixed)
    assert np.abs(found[-20:]).max() < 0.5
    assert np.abs(found).max() < 2.0


def test_a_reference_is_what_lines_are_compared_with() -> None:
    mean = measure_loudness(voice_of(voiced()), TRACK).mean
    np.testing.assert_allclose(decibels(voiced(), mean - 3), decibels(voiced()) + 3)
    np.testing.assert_allclose(decibels(voiced(), mean - 30), decibels(voiced()) + LIMIT)
    assert speech_level(voice_of(voiced())) == pytest.approx(mean, abs=1.5)


def test_silence_has_no_level() -> None:
    found = measure_loudness(voice_of(np.zeros(len(TIMES))), TRACK)
    assert not found.decibels.any()
    assert np.isnan(found.mean)
    assert np.isnan(speech_level(voice_of(np.zeros(len(TIMES)))))
    none = measure_loudness(analyze_voice(np.zeros(0, np.float32), RATE), TRACK)
    assert not none.at(np.array([0.0, 1.0])).any()
