import numpy as np
import pytest

from phonanim.media.voice import FRAMES, analyze_voice


def buzz(hertz, seconds=1.0, rate=16000, gain=0.3):
    times = np.arange(int(seconds * rate)) / rate
    return (gain * np.sign(np.sin(2 * np.pi * hertz * times))).astype(np.float32)


@pytest.mark.parametrize("hertz", [80, 123, 200, 333])
@pytest.mark.parametrize("rate", [8000, 22050, 44100])
def test_the_pitch_of_a_buzz(hertz, rate):
    voice = analyze_voice(buzz(hertz, rate=rate), rate)
    assert np.nanmedian(voice.pitch) == pytest.approx(hertz, rel=0.02)
    assert np.isfinite(voice.pitch).mean() > 0.9


def test_noise_and_silence_have_no_pitch():
    noise = np.random.default_rng(0).normal(0, 0.1, 16000).astype(np.float32)
    assert np.isfinite(analyze_voice(noise, 16000).pitch).mean() < 0.1
    assert np.isnan(analyze_voice(np.zeros(16000, np.float32), 16000).pitch).all()


def test_rumble_under_noise_has_no_pitch():
    """As in a room with a fan: a voice repeats, and is unlike itself within its period."""
    hum = 0.05 * np.cumsum(np.random.default_rng(1).normal(0, 1, 32000))
    hum -= np.convolve(hum, np.ones(1600) / 1600, "same")
    noise = np.random.default_rng(0).normal(0, 0.02, 32000)
    samples = (0.1 * hum / np.abs(hum).max() + 0.1 * noise).astype(np.float32)
    assert np.isfinite(analyze_voice(samples, 16000).pitch).mean() < 0.05


def test_level_is_of_full_scale():
    voice = analyze_voice(buzz(100, gain=0.1), 16000)
    assert voice.level[10:-10].mean() == pytest.approx(-20, abs=2)
    assert len(voice.level) == FRAMES


def test_any_stretch_is_that_of_the_whole():
    samples = buzz(110, 3.0) * np.linspace(0, 1, 48000, dtype=np.float32)
    whole = analyze_voice(samples, 16000)
    for first in (100, 101):
        part = analyze_voice(samples, 16000, first, 50)
        np.testing.assert_allclose(part.level, whole.level[first : first + 50], atol=1e-6)
        np.testing.assert_allclose(part.pitch, whole.pitch[first : first + 50], atol=1e-6)
        assert part.start == first / FRAMES


def test_no_sound_has_no_frames():
    voice = analyze_voice(np.zeros(0, np.float32), 16000)
    assert len(voice.level) == len(voice.pitch) == len(voice.active()) == len(voice.peaks()[0]) == 0
    assert voice.melody_at(np.array([0.5])).tolist() == [0.0]


def test_melody_rises_with_pitch():
    samples = np.concatenate([buzz(100, 1.5), buzz(150, 0.5)])
    melody = analyze_voice(samples, 16000).melody()
    assert melody[100] == pytest.approx(0.0, abs=0.2)
    assert melody[180] == pytest.approx(12 * np.log2(1.5), abs=1.7)  # less what the mean has risen


def test_speech_is_what_is_loud_next_to_the_last_seconds():
    quiet = np.random.default_rng(0).normal(0, 0.003, 16000).astype(np.float32)
    voice = analyze_voice(np.concatenate([quiet, buzz(100, 1.0), quiet]), 16000)
    active = voice.active()
    assert active[110:190].all()
    assert not active[215:].any()


def test_praat_finds_the_same_pitch_of_a_buzz():
    pytest.importorskip("parselmouth", reason="needs the extra pitch")
    from phonanim.media.praat import with_praat_pitch

    samples = np.concatenate([np.zeros(8000, np.float32), buzz(150)])
    voice = analyze_voice(samples, 16000)
    found = with_praat_pitch(voice, samples, 16000).pitch
    assert found.shape == voice.pitch.shape
    assert np.isnan(found[:45]).all()
    np.testing.assert_allclose(found[55:145], 150, rtol=0.01)
    short = samples[:100]
    assert np.isnan(with_praat_pitch(analyze_voice(short, 16000), short, 16000).pitch).all()
