import re
import sys
import wave

import numpy as np
import pytest

from phonanim.errors import AudioError, MissingExtraError
from phonanim.media import audio
from phonanim.media.audio import (
    Sound,
    audio_duration,
    audio_notes,
    find_audio,
    read_audio,
    resample,
    truncation_note,
)


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
    assert audio_duration(tmp_path / "a.wav") == 0.5


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
    assert audio_duration(tmp_path / "a.flac") == 0.5


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
    with pytest.raises(AudioError, match=r"empty.wav: contains no samples; record it again"):
        read_audio(tmp_path / "empty.wav")
    with pytest.raises(AudioError, match=r"missing.wav: cannot be read: No such file"):
        read_audio(tmp_path / "missing.wav")
    monkeypatch.setitem(sys.modules, "soundfile", None)
    with pytest.raises(MissingExtraError, match=r"a.wav: reading .wav needs pip install 'phonanim\[audio\]'"):
        read_audio(tmp_path / "a.wav")


def test_bytes_that_are_no_recording(tmp_path):
    pytest.importorskip("soundfile")
    (tmp_path / "a.flac").write_bytes(b"no such thing")
    with pytest.raises(AudioError, match=r"a.flac: is not a readable recording"):
        read_audio(tmp_path / "a.flac")
    with pytest.raises(AudioError, match=r"a.flac: is not a readable recording"):
        audio_duration(tmp_path / "a.flac")
    with pytest.raises(AudioError, match=r"Format not recognised; export it again"):
        read_audio(tmp_path / "a.flac")


def test_a_header_whose_numbers_make_no_sense(tmp_path):
    pytest.importorskip("soundfile")
    write(tmp_path / "a.wav", tone(16000))
    whole = bytearray((tmp_path / "a.wav").read_bytes())
    for place, size in ((22, 2), (24, 4)):  # channels, rate
        broken = bytearray(whole)
        broken[place : place + size] = bytes(size)
        (tmp_path / "a.wav").write_bytes(broken)
        with pytest.raises(AudioError, match=r"a.wav: is not a readable recording"):
            read_audio(tmp_path / "a.wav")
    (tmp_path / "a.flac").write_bytes(b"fLaC")
    with pytest.raises(AudioError, match=r"a.flac: is not a readable recording"):
        audio_duration(tmp_path / "a.flac")


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "FLOAT"])
def test_a_recording_that_is_cut_short(subtype, tmp_path):
    soundfile = pytest.importorskip("soundfile")
    path = tmp_path / "a.wav"
    soundfile.write(path, tone(16000), 16000, subtype=subtype)
    assert truncation_note(path) == ()
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2 + 1])
    (line,) = truncation_note(path)
    assert re.match(r"the recording is truncated: it contains 0\.2\d s of 0\.50 s; copy it again", line)
    assert len(read_audio(path)[0]) / 16000 == pytest.approx(audio_duration(path), abs=1e-3)


def test_a_header_written_before_the_sound_tells_of_no_length(tmp_path):
    write(tmp_path / "a.wav", tone(16000))
    whole = bytearray((tmp_path / "a.wav").read_bytes())
    whole[40:44] = b"\xff" * 4
    (tmp_path / "a.wav").write_bytes(whole)
    assert truncation_note(tmp_path / "a.wav") == ()
    assert audio_duration(tmp_path / "a.wav") == 0.5
    assert len(read_audio(tmp_path / "a.wav")[0]) == 8000


def test_samples_that_are_no_numbers(tmp_path):
    soundfile = pytest.importorskip("soundfile")
    samples = tone(16000, 21)
    samples[-1] = np.nan
    soundfile.write(tmp_path / "a.wav", samples, 16000, subtype="FLOAT")
    with pytest.raises(
        AudioError, match=r"a.wav: has samples after 20.0 s that are not finite numbers; export"
    ):
        read_audio(tmp_path / "a.wav")


@pytest.mark.parametrize("channels", [1, 2])
def test_long_recordings_lie_in_a_file(channels, tmp_path, monkeypatch):
    stereo = np.repeat(tone(8000, 25)[:, None], channels, axis=1)
    write(tmp_path / "a.wav", stereo, 8000, channels)
    short = read_audio(tmp_path / "a.wav")[0]
    monkeypatch.setattr("phonanim.core.files.LARGE", 1000)
    long = read_audio(tmp_path / "a.wav")[0]
    assert (isinstance(short, np.memmap), isinstance(long, np.memmap)) == (False, True)
    assert np.array_equal(short, long)


LOUD = np.where(np.arange(3000) % 7 < 2, 1.0, 0.2)
ODD = [
    (np.zeros(0), ("no audio was received",)),
    (np.zeros(3000), ("the audio was silent; check that it is the right one",)),
    (LOUD, ("the audio is clipped: 29 % of its samples are at full scale; record it quieter",)),
    (tone(16000), ()),
]


@pytest.mark.parametrize(("samples", "said"), ODD)
def test_what_is_odd_about_a_recording(samples, said, monkeypatch):
    assert audio_notes(Sound(samples.astype(np.float32), 16000)) == said
    monkeypatch.setattr("phonanim.media.audio.BLOCK", 1000)
    assert audio_notes(Sound(samples.astype(np.float32), 16000)) == said


@pytest.mark.parametrize("rate", [1, 999, 768_001, 2**31 - 1])
def test_rates_at_which_nobody_records(tmp_path, rate):
    with wave.open(str(tmp_path / "a.wav"), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(rate)
        stream.writeframes(bytes(200))
    message = rf"a\.wav: has {rate} samples per second; export it again with 1000 to 768000"
    with pytest.raises(AudioError, match=message):
        read_audio(tmp_path / "a.wav")


def test_recordings_that_never_end(tmp_path, monkeypatch):
    monkeypatch.setattr("phonanim.media.audio.LONGEST", 0)
    with wave.open(str(tmp_path / "a.wav"), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(8000)
        stream.writeframes(bytes(200))
    with pytest.raises(AudioError, match=r"a\.wav: is longer than 0 hours; cut it in parts"):
        read_audio(tmp_path / "a.wav")


def test_a_small_recording_that_unpacks_without_end_is_refused(tmp_path, monkeypatch):
    soundfile = pytest.importorskip("soundfile")
    path = tmp_path / "zeros.flac"
    soundfile.write(path, np.zeros((160_000, 2)), 16_000)
    assert len(read_audio(path)[0]) == 160_000
    monkeypatch.setattr(audio, "MOST_PER_BYTE", 1)
    monkeypatch.setattr(audio, "MOST_VALUES", 300_000)
    with pytest.raises(AudioError, match=r"zeros\.flac: unpacks to over 320,000 samples of all channels"):
        read_audio(path)
    monkeypatch.setattr(audio, "MOST_VALUES", 400_000)
    monkeypatch.setattr(audio, "MOST_SAMPLES", 100_000)
    with pytest.raises(AudioError, match=r"unpacks to over 160,000 samples; cut it in parts"):
        read_audio(path)
