import sys
import wave

import numpy as np
import pytest

from phonanim.audio import duration, find_audio, read_audio, resample
from phonanim.errors import AudioError, MissingExtraError


def write(path, samples, rate=16000, channels=1):
    with wave.open(str(path), "wb") as stream:
        stream.setnchannels(channels)
        stream.setsampwidth(2)
        stream.setframerate(rate)
        stream.writeframes((samples * 32768).astype("<i2").tobytes())


def tone(rate, seconds=0.5, hertz=440.0):
    return (0.5 * np.sin(2 * np.pi * hertz * np.arange(round(rate * seconds)) / rate)).astype(np.float32)


def test_wav_is_read_without_an_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "soundfile", None)
    write(tmp_path / "a.wav", tone(16000))
    samples, rate = read_audio(tmp_path / "a.wav")
    assert (rate, samples.dtype) == (16000, np.float32)
    np.testing.assert_allclose(samples, tone(16000), atol=1 / 32768)
    assert duration(tmp_path / "a.wav") == 0.5


def test_channels_are_averaged(tmp_path):
    stereo = np.stack([tone(8000), -tone(8000)], axis=1)
    write(tmp_path / "a.wav", stereo, 8000, 2)
    assert np.abs(read_audio(tmp_path / "a.wav")[0]).max() < 1e-4


def test_flac_is_read_by_soundfile(tmp_path):
    soundfile = pytest.importorskip("soundfile")
    soundfile.write(tmp_path / "a.flac", tone(22050), 22050)
    samples, rate = read_audio(tmp_path / "a.flac")
    assert rate == 22050
    np.testing.assert_allclose(samples, tone(22050), atol=1 / 16384)
    assert duration(tmp_path / "a.flac") == 0.5


@pytest.mark.parametrize(("rate", "target"), [(16000, 22050), (22050, 16000), (48000, 16000), (16000, 16000)])
def test_resampling_keeps_a_tone(rate, target):
    got = resample(tone(rate), rate, target)
    inner = slice(len(got) // 10, -len(got) // 10)
    np.testing.assert_allclose(got[inner], tone(target)[inner], atol=0.01)


def test_the_recording_beside(tmp_path):
    assert find_audio(tmp_path / "a.TextGrid") is None
    (tmp_path / "a.flac").touch()
    assert find_audio(tmp_path / "a.TextGrid") == tmp_path / "a.flac"
    (tmp_path / "a.wav").touch()
    assert find_audio(tmp_path / "a.TextGrid") == tmp_path / "a.wav"


def test_recordings_that_are_none(tmp_path, monkeypatch):
    (tmp_path / "a.wav").write_bytes(b"RIFF but no more")
    (tmp_path / "silent.wav").touch()
    write(tmp_path / "empty.wav", np.zeros(0))
    with pytest.raises(AudioError, match=r"empty.wav: holds no sound; record it again"):
        read_audio(tmp_path / "empty.wav")
    with pytest.raises(AudioError, match=r"missing.wav: cannot be read: No such file"):
        read_audio(tmp_path / "missing.wav")
    monkeypatch.setitem(sys.modules, "soundfile", None)
    with pytest.raises(MissingExtraError, match=r"a.wav: reading .wav needs pip install 'phonanim\[audio\]'"):
        read_audio(tmp_path / "a.wav")


def test_bytes_that_are_no_recording(tmp_path):
    pytest.importorskip("soundfile")
    (tmp_path / "a.flac").write_bytes(b"no such thing")
    with pytest.raises(AudioError, match=r"a.flac: is no recording that can be read"):
        read_audio(tmp_path / "a.flac")
    with pytest.raises(AudioError, match=r"a.flac: is no recording that can be read"):
        duration(tmp_path / "a.flac")
