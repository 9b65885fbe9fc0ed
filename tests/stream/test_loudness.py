"""The level of a recording that arrives with its phones."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from voices import RATE, TIMES, TRACK, voiced

from phonanim.__main__ import run
from phonanim.media.voice import analyze_voice
from phonanim.options import Options
from phonanim.speech.loudness import measure_loudness
from phonanim.stream.engine import PhoneStream
from phonanim.stream.events import Phone, Samples, Tick
from phonanim.stream.loudness import StreamedLoudness

LOUDER = voiced() * np.where(TIMES > 3.5, 2.0, 1.0).astype(np.float32)
OPTIONS = Options(fps=30, life=0)


def streamed(block: float, options: Options = OPTIONS, every: bool = True) -> np.ndarray:
    """Frames of the line, whose audio comes in blocks of so many seconds."""
    engine = PhoneStream(options, None, rate=RATE)
    frames, given, size = [], 0, round(block * RATE)
    for label, start, end in zip(TRACK.labels, TRACK.bounds[:-1], TRACK.bounds[1:], strict=True):
        while given < end * RATE:
            engine.take(Samples(LOUDER[given : given + size]))
            given += size
        engine.take(Phone(label.upper(), float(start), float(end)))
        if every:
            frames.append(engine.frames())
    engine.take(Tick(TRACK.duration))
    engine.end()
    return np.concatenate([*frames, engine.frames()])


def test_frames_do_not_depend_on_how_audio_arrives() -> None:
    whole = streamed(10.0, every=False)
    np.testing.assert_allclose(streamed(0.1), whole, atol=1e-6)
    np.testing.assert_allclose(streamed(0.013), whole, atol=1e-6)
    even = streamed(0.1, replace(OPTIONS, loudness=0.0))
    half = len(whole) // 2
    jaw = PhoneStream(OPTIONS).rig.controls.index("jawOpen")
    assert np.abs(whole - even)[:half, jaw].max() < 0.02
    assert (whole - even)[half + 15 :, jaw].max() > 0.02


@pytest.mark.parametrize("reference", [None, -20.0])
def test_the_level_is_near_that_of_the_whole_line(reference: float | None) -> None:
    """It comes later, and the first words do not know of the louder ones to come."""
    voice = analyze_voice(LOUDER, RATE)
    times = np.arange(1.0, TRACK.duration - 1, 0.1)
    whole = measure_loudness(voice, TRACK, reference).at(times)
    found = StreamedLoudness(reference)
    streamed = np.concatenate(
        [found.until(time, voice, TRACK, 0.0).at(np.array([time])) for time in times.tolist()]
    )
    assert np.corrcoef(streamed, whole)[0, 1] > 0.7
    assert np.abs(streamed).max() <= 12


def test_noise_has_no_loudness() -> None:
    noise = np.random.default_rng(0).normal(0, 0.1, len(TIMES)).astype(np.float32)
    found = StreamedLoudness().until(TRACK.duration, analyze_voice(noise, RATE), TRACK, 0.0)
    assert np.abs(found.decibels).max() < 0.5


def test_a_recording_that_is_named_must_be_readable(
    line_without_sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = tmp_path / "a.wav"
    broken.write_bytes(b"RIFF")
    assert run(["stream", str(line_without_sound), "--audio", str(broken)]) == 2
    assert "a.wav" in capsys.readouterr().err


def test_a_recording_is_of_an_alignment(
    root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.jsonl").write_text('{"end": true}\n')
    sound = root / "examples" / "line.wav"
    assert run(["stream", str(tmp_path / "a.jsonl"), "--audio", str(sound)]) == 2
    assert "is for the recording of an alignment; leave it out" in capsys.readouterr().err
