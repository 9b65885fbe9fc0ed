"""`phonanim animate` by an audio-driven model: a recording alone, or an alignment with its recording."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples

from phonanim.__main__ import run
from phonanim.errors import AlignmentError, AudioError
from phonanim.inputs.speech_input import InputModality, is_recording, read_speech_input
from phonanim.media.audio import Sound, find_audio, read_sound
from phonanim.options import DEFAULTS
from phonanim.pipeline import animate, load_model
from phonanim.regressors import Model, make_config, regressor_class, save


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A small audio-driven model, for the shipped face."""
    pytest.importorskip("torch")
    face = load_model("default").face
    data = made_up_examples(np.random.default_rng(5), clips=3, modes=len(face.std))
    config = make_config("two_stage", {"encoder": "mfcc", "hidden": 4, "depth": 1, "epochs": 1}, "test")
    fit: Any = regressor_class("two_stage").fit
    regressor = fit(config, data, data, np.random.default_rng(1), lambda done: None)
    folder = tmp_path_factory.mktemp("models") / "audio_driven"
    save(Model(regressor, face, {"fps": 25.0}), folder)
    return str(folder)


def test_a_recording_alone(line: Path, model: str, capsys: pytest.CaptureFixture[str]) -> None:
    (line / "a.TextGrid").unlink()
    assert run(["animate", "a.wav", "--model", model, "-o", "a.csv", "--rig", "arkit"]) == 0
    said = capsys.readouterr().err
    assert said.startswith("read a.wav: 0 phones in ")
    assert "there is no alignment: lip closures are as predicted from the audio, none is enforced" in said
    animation = animate(Path("a.wav"), replace(DEFAULTS, model=model))
    sound = read_sound(line / "a.wav")
    assert animation.audio == Path("a.wav")
    assert len(animation.values) == int(sound.duration * 60) + 1
    assert animation.values.std(axis=0).max() > 0


def test_an_alignment_with_its_recording(line: Path, model: str) -> None:
    options = replace(DEFAULTS, model=model)
    found = animate(Path("a.TextGrid"), options)
    assert len(found.phones) > 5
    assert found.provenance["audio_sha256"] != found.provenance["input_sha256"]
    free = replace(options, contacts=False)
    spoken, from_sound = (animate(Path(name), free).values for name in ("a.TextGrid", "a.wav"))
    shared = min(len(spoken), len(from_sound))
    assert spoken.shape[1] == from_sound.shape[1]
    assert shared > 60


@pytest.mark.parametrize("modality", ["phones", "both"])
def test_the_model_that_reads_says_what_it_needs(line: Path, modality: InputModality) -> None:
    wanted = (
        r"^a\.wav: is a recording, and this model needs an alignment; give the spoken words with "
        "--text, or choose --model audio, which recognizes phones$"
    )
    with pytest.raises(AlignmentError, match=wanted):
        read_speech_input(Path("a.wav"), DEFAULTS, None, modality)


def test_nothing_to_recognize(line: Path, model: str, capsys: pytest.CaptureFixture[str]) -> None:
    (line / "a.wav").unlink()
    assert run(["animate", "a.TextGrid", "--model", model, "-o", "a.csv"]) == 2
    assert (
        "a.TextGrid: has no recording next to it for this audio-driven model; give --audio"
        in capsys.readouterr().err
    )
    with pytest.raises(AudioError, match="give --audio$"):
        read_speech_input(Path("a.TextGrid"), DEFAULTS, None, "audio")


@pytest.mark.parametrize("content", [b"", b"RIFF but no more", b"no sound at all"])
def test_a_recording_that_is_none(
    content: bytes, line: Path, model: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("soundfile")
    (line / "b.wav").write_bytes(content)
    assert run(["animate", "b.wav", "--model", model, "-o", "b.csv"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("phonanim: b.wav: is not a readable recording")
    assert said.count("\n") == 1
    assert not (line / "b.csv").exists()


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "FLOAT"])
@pytest.mark.parametrize("seconds", [0.005, 0.5])
def test_recordings_of_every_kind(subtype: str, seconds: float, line: Path, model: str) -> None:
    soundfile = pytest.importorskip("soundfile")
    noise = np.random.default_rng(0).normal(0, 2, (round(44100 * seconds), 2))  # clipped where it is PCM
    soundfile.write(line / "b.wav", noise, 44100, subtype=subtype)
    found = animate(Path("b.wav"), replace(DEFAULTS, model=model))
    assert len(found.values) == int(seconds * 60) + 1
    assert np.isfinite(found.values).all()


def test_what_is_odd_about_the_sound_is_said(
    line: Path, model: str, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = (line / "a.wav").read_bytes()
    (line / "b.wav").write_bytes(whole[: len(whole) // 2])
    (line / "c.wav").write_bytes(whole[:44] + bytes(len(whole) - 44))
    shutil.copy(line / "c.wav", line / "a.wav")
    said = {}
    for name in ("a.TextGrid", "b.wav", "c.wav"):
        assert run(["animate", name, "--model", model, "-o", "o.csv", "--rig", "arkit"]) == 0
        said[name] = capsys.readouterr().err
    assert "the recording is truncated: it contains 2.26 s of 4.52 s; copy it again" in said["b.wav"]
    assert "the audio was silent; check that it is the right one" in said["c.wav"]
    assert "the audio was silent; check that it is the right one" in said["a.TextGrid"]


def test_an_alignment_cut_out_of_a_longer_recording(
    line: Path, model: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    import phonanim.inputs.speech_input as sources

    real = sources.read_alignment
    monkeypatch.setattr(sources, "read_alignment", lambda *given: replace(real(*given), offset=0.5))
    sound = read_speech_input(Path("a.TextGrid"), DEFAULTS, None, "audio").sound
    whole = read_sound(Path("a.wav"))
    assert isinstance(sound, Sound)
    assert np.array_equal(sound.samples, whole.samples[round(0.5 * whole.rate) :])


def test_the_recording_of_a_path(line: Path) -> None:
    assert is_recording(Path("x.WAV"))
    assert not is_recording(Path("x.TextGrid"))
    assert find_audio(Path("a.TextGrid")) == Path("a.wav")
    assert find_audio(Path("no.flac")) == Path("no.flac")


def test_the_card_names_the_encoder(model: str) -> None:
    assert json.loads((Path(model) / "model.json").read_text())["config"]["encoder"] == "mfcc"
