"""Sound streamed through the phones recognized in it: the frames of the whole recording, and refusals."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.core.catalog import RECOGNITION_MODEL
from phonanim.errors import StreamError
from phonanim.media.audio import read_sound
from phonanim.options import Options
from phonanim.pipeline import animate
from phonanim.recognition.recognizer import mean_of
from phonanim.recognition.spectrum import VoiceMean
from phonanim.stream.events import Phone, Samples
from phonanim.stream.recognized import RecognizedStream

OPTIONS = Options(model=RECOGNITION_MODEL, life=0, loudness=0)
SECONDS = 1.6


@pytest.fixture(scope="module")
def recording(root: Path) -> Path:
    return root / "examples" / "line.wav"


def streamed(path: Path, ahead: float | None, block: int, seconds: float = SECONDS) -> np.ndarray:
    sound = read_sound(path)
    mean = mean_of(path) if ahead is None else VoiceMean()
    stream = RecognizedStream(OPTIONS, sound.rate, ahead, mean=mean)
    samples, found = sound.samples, []
    samples = samples[: int(seconds * sound.rate)]
    for begin in range(0, len(samples), block):
        stream.take(Samples(samples[begin : begin + block]))
        found.append(stream.frames())
    stream.end()
    return np.concatenate([*found, stream.frames()])


def test_with_time_enough_it_gives_what_animate_gives(recording: Path) -> None:
    whole = animate(recording, OPTIONS).values
    assert np.ptp(whole, axis=0).max() > 0.3
    found = streamed(recording, None, 4000, 60.0)
    assert len(found) == len(whole)
    np.testing.assert_allclose(found, whole, atol=1e-6)


def test_pieces_of_sound_do_not_matter(recording: Path) -> None:
    few, many = (streamed(recording, None, block, 1.0) for block in (8000, 800))
    np.testing.assert_allclose(few, many, atol=1e-6)


def test_frames_wait_for_a_fifth_of_a_second(recording: Path) -> None:
    sound = read_sound(recording)
    stream = RecognizedStream(OPTIONS, sound.rate, 0.2)
    assert stream.look_ahead == pytest.approx(0.2)
    stream.take(Samples(sound.samples[: sound.rate]))
    assert stream.ready / 60 == pytest.approx(1.0 - 0.2, abs=0.03)
    assert RecognizedStream(OPTIONS, sound.rate, 0.0).look_ahead == pytest.approx(stream.slowest)


def test_what_is_no_sound() -> None:
    stream = RecognizedStream(OPTIONS)
    with pytest.raises(StreamError, match="ignores phones"):
        stream.take(Phone("AA", 0.0, 0.1))
    with pytest.raises(StreamError, match="2 samples before 0.01 s are not finite"):
        stream.take(Samples(np.array([np.nan] * 2 + [0.0] * 158, np.float32)))


def test_a_recording_needs_no_model(recording: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["stream", str(recording), "--life", "0"]) == 0
    assert capfd.readouterr().err.startswith("arkit by audio, 60 fps")


def test_without_a_microphone_one_line_says_so(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    assert run(["stream", "--mic", "--life", "0"]) == 2
    said = capfd.readouterr().err.splitlines()
    assert len(said) == 2
    assert said[1].startswith("phonanim: a microphone needs pip install 'phonanim[stream]'")
