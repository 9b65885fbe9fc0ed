"""Sound in as it comes, frames out: the same as of the whole recording, in bounded memory."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from streams import made_up_model, speech

from phonanim.animation.rates import frame_count
from phonanim.animation.style import scale_controls
from phonanim.encoders import RATE
from phonanim.errors import MissingExtraError, OptionError, StreamError
from phonanim.media.audio import Sound
from phonanim.options import Options
from phonanim.pipeline import load_cached_rig, load_model
from phonanim.rig.retarget import retarget
from phonanim.stream.events import Phone, Samples
from phonanim.stream.sound import SoundStream


@pytest.fixture(scope="module", params=["cnn", "tcn"])
def options(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Options:
    folder = made_up_model(tmp_path_factory.mktemp("models") / request.param, request.param)
    return Options(life=0, model=str(folder), jaw=1.2)


def whole(samples: np.ndarray, options: Options, rate: int = RATE) -> np.ndarray:
    model, rig = load_model(options.model), load_cached_rig(options.rig)
    frames = frame_count(len(samples) / rate, options.fps)
    modes = model.predict(None, options.fps, frames, sound=Sound(samples, rate))
    values = retarget(modes, model.face, rig)
    return scale_controls(values, rig, options.intensity, options.jaw, options.lips, options.gains)


def streamed(samples: np.ndarray, options: Options, block: int, rate: int = RATE) -> np.ndarray:
    stream = SoundStream(options, rate)
    found = []
    for begin in range(0, len(samples), block):
        stream.take(Samples(samples[begin : begin + block]))
        found.append(stream.frames())
        assert len(stream.modes) < 40
        assert len(stream.steps.samples) < 40 * 320
    stream.end()
    return np.concatenate([*found, stream.frames()])


@pytest.mark.parametrize("seconds", [0.005, 0.3, 1.0, 2.507])
@pytest.mark.parametrize("block", [160, 333, 4000])
def test_a_stream_gives_what_the_whole_recording_gives(seconds: float, block: int, options: Options) -> None:
    samples = speech(seconds)
    batch = whole(samples, options)
    np.testing.assert_allclose(streamed(samples, options, block), batch, atol=2e-3)
    assert np.ptp(batch, axis=0).max() > 0.1 or seconds < 0.1


@pytest.mark.parametrize("fps", [25.0, 50.0, 29.97])
def test_at_any_rate_of_frames(fps: float, options: Options) -> None:
    other, samples = Options(life=0, model=options.model, fps=fps), speech(1.23)
    np.testing.assert_allclose(streamed(samples, other, 160), whole(samples, other), atol=2e-3)


@pytest.mark.parametrize("rate", [8000, 22050, 44100, 48000])
def test_sound_of_another_rate(rate: int, options: Options) -> None:
    pytest.importorskip("soxr")
    samples = speech(1.5, rate)
    found, batch = streamed(samples, options, rate // 100, rate), whole(samples, options, rate)
    assert found.shape == batch.shape
    inner = slice(15, -15)  # at its ends, Fourier resampling of a whole recording rings
    assert np.abs(found - batch)[inner].mean() < 0.02


def test_a_frame_waits_for_the_look_ahead_and_no_longer(options: Options) -> None:
    stream, fed = SoundStream(options), 0.0
    for _ in range(150):
        stream.take(Samples(np.zeros(160, np.float32)))
        fed += 0.01
        stream.frames()
        certain = fed - stream.look_ahead
        assert stream.emitted >= np.floor((certain - 0.001) * 60 + 1e-6) + (certain > 0.001)
        assert stream.emitted <= np.floor(max(certain + 0.02, 0) * 60 + 1e-6) + 1


@pytest.mark.parametrize("sound", ["silent", "clipped"])
def test_odd_sounds(sound: str, options: Options) -> None:
    samples = np.zeros(8000) if sound == "silent" else np.sign(np.sin(np.arange(8000) / 7))
    found = streamed(samples.astype(np.float32), options, 160)
    stream = SoundStream(options)
    stream.take(Samples(samples.astype(np.float32)))
    said = {"silent": "the audio was silent; check", "clipped": "the audio is clipped: 100 % of its samples"}
    assert said[sound] in " ".join(stream.notes)
    assert found.shape == (31, 55)
    assert np.isfinite(found).all()


def test_samples_that_are_no_numbers(options: Options) -> None:
    stream = SoundStream(options)
    samples = np.zeros(1600, np.float32)
    samples[:3] = np.nan, np.inf, -np.inf
    with pytest.raises(
        StreamError, match=r"3 samples before 0.10 s are not finite numbers and count as silence"
    ):
        stream.take(Samples(samples))
    stream.take(Samples(np.zeros(8000, np.float32)))
    assert np.isfinite(stream.frames()).all()


def test_what_is_no_sound(options: Options) -> None:
    with pytest.raises(StreamError, match="the model is audio-driven and ignores phones; send it audio"):
        SoundStream(options).take(Phone("AA1", 0, 1))


def test_sound_that_stalls_counts_as_silence(options: Options) -> None:
    stream = SoundStream(options)
    stream.take(Samples(speech(0.5)))
    stream.pass_time(1.5)
    stalled = stream.frames()
    quiet = streamed(np.concatenate([speech(0.5), np.zeros(RATE, np.float32)]), options, 160)
    np.testing.assert_allclose(stalled, quiet[: len(stalled)], atol=2e-3)


def test_an_empty_stream_has_no_frames(options: Options) -> None:
    stream = SoundStream(options)
    stream.end()
    stream.end()
    assert stream.frames().shape == (0, 55)


def test_models_that_cannot_take_sound(options: Options, tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="model default cannot be streamed; choose one of kind"):
        SoundStream(Options())
    slow = made_up_model(tmp_path / "slow", "cnn", rate=25.0)
    with pytest.raises(OptionError, match="predicts 25 times per second, not 50"):
        SoundStream(Options(life=0, model=str(slow)))
    with pytest.raises(OptionError, match="rig rhubarb needs phones, not audio; choose another"):
        SoundStream(Options(life=0, model=options.model, rig="rhubarb"))


def test_another_rate_needs_an_extra(options: Options, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "soxr", None)
    with pytest.raises(
        MissingExtraError,
        match=r"audio of 44100 Hz needs pip install 'phonanim\[stream\]', or audio of 16000",
    ):
        SoundStream(options, 44100)
