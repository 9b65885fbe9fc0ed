"""What holds for every encoder: any recording becomes steps of 20 ms, the same ones each time."""

from __future__ import annotations

import wave
from pathlib import Path

import numpy as np
import pytest
from encoder_samples import HIDDEN, Loudness, put, speech
from speech import sound_of, track_of

from phonanim.encoders import HOP, RATE, Encoder, Features, encode, encoder_names, load_encoder
from phonanim.encoders._weights import encoder_folder
from phonanim.encoders.phones import track_features
from phonanim.errors import AudioError, ModelError
from phonanim.media.audio import Sound, read_sound
from phonanim.speech.inventory import INVENTORY


@pytest.fixture(scope="module", params=[name for name in encoder_names() if name != "precomputed"])
def encoder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Encoder:
    folder = tmp_path_factory.mktemp(request.param)
    put(folder, request.param)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PHONANIM_ENCODERS", str(folder))
        return load_encoder(request.param)


@pytest.mark.parametrize(
    ("seconds", "rate", "steps"), [(1.0, RATE, 50), (0.99, 48000, 50), (1.005, 22050, 51), (0.005, 16000, 1)]
)
def test_steps_cover_the_recording(encoder: Encoder, seconds: float, rate: int, steps: int) -> None:
    found = encode(encoder, speech(seconds, rate))
    assert found.values.shape == (steps, encoder.layers, encoder.dims)
    assert found.values.dtype == np.float16
    assert found.rate == RATE / HOP
    assert 0 <= found.start <= 0.02
    assert encoder.window > 2 * encoder.margin > 0


@pytest.mark.parametrize("sound", ["silent", "clipped", "one sample", "loud"])
def test_odd_sounds_give_numbers(encoder: Encoder, sound: str) -> None:
    samples = {
        "silent": np.zeros(8000),
        "clipped": np.sign(np.sin(np.arange(8000) / 5)),
        "one sample": np.full(1, 0.5),
        "loud": 1000 * np.sin(np.arange(8000) / 5),
    }[sound]
    found = encode(encoder, Sound(samples.astype(np.float32), RATE))
    assert np.isfinite(found.values).all()


def test_the_same_sound_gives_the_same_bytes(encoder: Encoder) -> None:
    first, second = (encode(encoder, speech(0.7)).values for _ in range(2))
    assert first.tobytes() == second.tobytes()


def test_a_sound_that_comes_later_is_encoded_later(encoder: Encoder) -> None:
    if encoder.identity.startswith("phones"):
        pytest.skip("noise is no phone")
    quiet = np.zeros(RATE, np.float32)
    click = quiet.copy()
    click[RATE // 2 : RATE // 2 + 160] = 0.5
    apart = np.abs(encoder.run(click) - encoder.run(quiet)).sum(axis=(1, 2))
    if encoder.identity.startswith("mfcc"):
        assert abs(encoder.start + int(apart.argmax()) / 50 - 0.505) <= 0.1
    assert apart[25] > 0


@pytest.mark.parametrize("seconds", [3.0, 12.0, 12.01, 25.3, 100.0])
def test_windows_join_without_a_seam(seconds: float) -> None:
    ramp = np.linspace(0, 1, round(seconds * RATE)).astype(np.float32)
    lengths: list[int] = []
    found = encode(Loudness(lengths), Sound(ramp, RATE)).values[:, 0]
    whole = np.pad(ramp, (0, -len(ramp) % HOP)).reshape(-1, HOP).mean(axis=1)
    np.testing.assert_allclose(found[:, 0], whole, atol=1e-3)
    assert (found[:, 1] == 1).all()
    assert max(lengths) <= 12 * RATE


def test_three_hours_in_bounded_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import tracemalloc

    monkeypatch.setenv("PHONANIM_CACHE", str(tmp_path))
    sound = Sound(np.zeros(3 * 3600 * RATE, np.float32), RATE)  # zeros that nobody wrote take no memory
    tracemalloc.start()
    found = encode(Loudness([]), sound)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.values.shape == (540000, 1, 2)
    assert isinstance(found.values, np.memmap)
    assert peak < 50e6


def test_features_at_instants() -> None:
    values = (np.arange(100, dtype=np.float16) / 50)[:, None, None]
    features = Features(values, 50.0, 0.0)
    times = np.array([-1.0, 0.0, 0.51, 1.0, 9.0])
    np.testing.assert_allclose(features.at(times)[:, 0, 0], [0, 0, 0.51, 1, 99 / 50], atol=1e-3)
    np.testing.assert_allclose(features.at(times[2:4], span=0.04)[:, 0, 0], [0.51, 1], atol=1e-3)
    wiggle = Features(np.tile(np.array([0, 1], np.float16), 50)[:, None, None], 50.0, 0.0)
    np.testing.assert_allclose(wiggle.at(np.arange(0.2, 1, 0.1), span=0.1)[:, 0, 0], 0.5, atol=0.11)


def test_recordings_without_sound() -> None:
    with pytest.raises(AudioError, match="the recording contains no samples; record it again"):
        encode(Loudness([]), Sound(np.zeros(0, np.float32), RATE))
    with pytest.raises(AudioError, match="has samples that are not finite numbers; export it again"):
        encode(Loudness([]), Sound(np.array([0, np.nan], np.float32), RATE))


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "FLOAT"])
def test_stereo_of_any_depth_sounds_the_same(subtype: str, tmp_path: Path) -> None:
    soundfile = pytest.importorskip("soundfile")
    mono = speech(0.5, 44100).samples
    soundfile.write(tmp_path / "a.wav", np.stack([mono, mono], axis=1), 44100, subtype=subtype)
    found = encode(load_encoder("mfcc"), read_sound(tmp_path / "a.wav")).values
    reference = encode(load_encoder("mfcc"), Sound(mono, 44100)).values
    np.testing.assert_allclose(found.astype(float), reference.astype(float), atol=0.05)


def test_a_file_that_is_no_recording(tmp_path: Path) -> None:
    pytest.importorskip("soundfile")
    (tmp_path / "a.wav").write_bytes(b"not audio at all")
    with pytest.raises(AudioError, match=r"a.wav: is not a readable recording"):
        read_sound(tmp_path / "a.wav")


def test_an_unknown_encoder() -> None:
    with pytest.raises(ModelError, match="there is no encoder 'wisper'; did you mean 'whisper'"):
        load_encoder("wisper")


@pytest.mark.parametrize("name", [*HIDDEN, "whisper"])
def test_weights_that_are_missing(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    monkeypatch.setattr("phonanim.encoders._weights.find_spec", lambda name: None)
    name_of = "Whisper" if name == "whisper" else name
    with pytest.raises(ModelError, match=rf"^{name_of} has no weights: .*{name}$"):
        load_encoder(name)


def test_where_weights_are_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PHONANIM_ENCODERS", raising=False)
    for platform, variable in (("linux", "XDG_DATA_HOME"), ("win32", "LOCALAPPDATA")):
        monkeypatch.setattr("sys.platform", platform)
        monkeypatch.setenv(variable, "base")
        assert encoder_folder("whisper") == Path("base/phonanim/encoders/whisper")
    monkeypatch.setattr("sys.platform", "darwin")
    assert encoder_folder("x").as_posix().endswith("Library/Application Support/phonanim/encoders/x")


def test_phones_of_an_alignment() -> None:
    found = track_features(track_of("sil 0.1 m 0.1 aa 0.1"))
    assert found.values.shape == (15, 1, 41)
    assert (found.values.sum(axis=2) == 1).all()
    expected = np.repeat(INVENTORY.codes(["sil", "m", "aa"]), 5)
    assert np.array_equal(found.values[:, 0].argmax(axis=1), expected)


def test_phones_that_nobody_said() -> None:
    pytest.importorskip("pocketsphinx")
    found = encode(load_encoder("phones"), Sound(np.zeros(RATE, np.float32), RATE)).values
    assert (found[:, 0, 0] == 1).all()


def test_a_sixteen_bit_wav_needs_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "soundfile", None)
    sound = sound_of(track_of("sil 0.1 aa 0.3"), 8000)
    with wave.open(str(tmp_path / "a.wav"), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(8000)
        stream.writeframes((sound.samples * 32767).astype("<i2").tobytes())
    assert encode(load_encoder("mfcc"), read_sound(tmp_path / "a.wav")).values.shape == (20, 1, 54)
