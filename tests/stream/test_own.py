"""Live motion of models of controls, sensors and vertices: that of the whole line, frame by frame."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import dataset_samples
import numpy as np
import pytest
from click.testing import CliRunner
from motions import KINDS, made_up_motion
from streams import speech

from phonanim import animate
from phonanim.__main__ import run
from phonanim.commands._mesh import predict_mesh
from phonanim.commands.stream import command as stream
from phonanim.corpus.motion import load_motion_corpus, save_motion_corpus
from phonanim.encoders import RATE
from phonanim.media.audio import Sound
from phonanim.options import DEFAULTS, Options
from phonanim.pipeline import load_model
from phonanim.stream import inputs
from phonanim.stream.engine import PhoneStream
from phonanim.stream.events import Samples
from phonanim.stream.sound import SoundStream

LINE = Path(__file__).parents[2] / "examples" / "line.TextGrid"


@pytest.fixture(scope="module", params=KINDS)
def model(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = made_up_motion(request.param, tmp_path_factory.mktemp(request.param))
    (folder / "recipe.toml").write_text('kind = "phone_mean"\ncorpus = "corpus"\n')
    assert run(["train", str(folder / "recipe.toml"), "-o", str(folder / "model"), "--quiet"]) == 0
    return str(folder / "model")


def settings(model: str) -> Options:
    kind = load_model(model).target.kind
    rig = "arkit_tongue" if kind == "sensors" else DEFAULTS.rig
    return replace(DEFAULTS, model=model, fps=30.0, rig=rig, life=0.0)


def test_frames_are_those_of_the_line(model: str) -> None:
    options = settings(model)
    language, words, _, events = inputs.alignment_file(LINE, options)
    engine = PhoneStream(replace(options, language=language), None, LINE.stem, words)
    frames = []
    for event in events:
        engine.take(event)
        frames.append(engine.frames(7))
    engine.end()
    frames.append(engine.frames())
    found = np.concatenate(frames)
    if load_model(model).target.kind == "vertices":
        whole = predict_mesh(LINE, (), options, None, None)[0].points.reshape(len(found), -1)
        assert engine.rig.controls[:4] == ("v0x", "v0y", "v0z", "v1x")
    else:
        line = animate(LINE, options)
        whole = line.values
        assert engine.rig.controls == line.channels
        assert engine.rig.name == line.rig
    assert found.shape == whole.shape
    np.testing.assert_allclose(found, whole, atol=2e-4)
    assert np.ptp(found, axis=0).max() > 0.1


def test_a_style_is_streamed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """On the face of its speaker, and as the whole line is."""
    folder = made_up_motion("vertices", tmp_path)
    corpus = load_motion_corpus(folder / "corpus")
    rest = corpus.source.templates["anna"]
    source = replace(corpus.source, templates={"anna": rest, "bert": 2 * rest})
    clips = tuple(
        replace(clip, subject="bert" if number % 2 else "anna") for number, clip in enumerate(corpus.clips)
    )
    save_motion_corpus(replace(corpus, source=source, clips=clips), folder / "corpus")
    (folder / "recipe.toml").write_text('kind = "phone_mean"\ncorpus = "corpus"\n')
    assert run(["train", str(folder / "recipe.toml"), "-o", str(folder / "model"), "--quiet"]) == 0
    options = replace(settings(str(folder / "model")), model_style=1)
    engine = PhoneStream(options, 0.0)
    assert engine.rig.rest == pytest.approx(2 * rest.ravel())
    given = ["stream", str(LINE), "--model", options.model, "--look-ahead", "exact", "--fps", "30", "--style"]
    capfd.readouterr()
    frames = []
    for style in ("anna", "1", "bert"):
        assert run([*given, style]) == 0
        frames.append(capfd.readouterr().out.splitlines()[-1])
    assert frames[0] != frames[1] == frames[2]
    whole = predict_mesh(LINE, (), options, None, None)[0].points.reshape(-1, 15)
    assert json.loads(frames[2])["values"] == pytest.approx(whole[-1], abs=2e-3)
    assert run([*given[:3], "default", "--style", "1"]) == 2
    assert "the model default has no styles: leave out --style" in capfd.readouterr().err


def test_the_command_plays_it(model: str) -> None:
    found = CliRunner().invoke(stream, [str(LINE), "--model", model, "--look-ahead", "exact", "--fps", "25"])
    assert found.exit_code == 0, found.output
    kind, to = load_model(model).target.kind, "osc=127.0.0.1:9"
    other = CliRunner().invoke(stream, [str(LINE), "--model", model, "--to", to])
    if kind == "vertices":
        assert "takes controls of a rig, and the model moves 5 vertices; use --to stdout" in str(
            other.exception
        )
    else:
        assert "takes controls" not in str(other.exception)


def test_controls_go_to_a_rig_by_a_table_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = made_up_motion("controls", tmp_path)
    (folder / "recipe.toml").write_text('kind = "phone_mean"\ncorpus = "corpus"\n')
    assert run(["train", str(folder / "recipe.toml"), "-o", str(folder / "model"), "--quiet"]) == 0
    given = ["stream", str(LINE), "--model", str(folder / "model")]
    assert run([*given, "--rig", "metahuman"]) == 2
    assert "no table leads from them to the rig metahuman" in capsys.readouterr().err
    assert run([*given, "--jaw", "1.5"]) == 0
    assert "the model moves controls of its data set, so jaw did nothing" in capsys.readouterr().err


def test_sound_moves_controls_as_they_come(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    dataset_samples.facegood(tmp_path)
    corpus = ["corpus", "build", str(tmp_path), "--dataset", "facegood", "-o", str(tmp_path / "corpus")]
    assert run([*corpus, "--quiet"]) == 0
    small = "kernels = [3, 3]\ndilations = [1, 1]\nchannels = [6, 6]\nahead = 2\nepochs = 1\nwindow = 20"
    (tmp_path / "r.toml").write_text(f'kind = "cnn"\ncorpus = "corpus"\n[settings]\n{small}\n')
    assert run(["train", str(tmp_path / "r.toml"), "-o", str(tmp_path / "model"), "--quiet"]) == 0
    options = replace(DEFAULTS, model=str(tmp_path / "model"), fps=30.0)
    samples, model = speech(1.23), load_model(options.model)
    engine, frames = SoundStream(options), []
    for begin in range(0, len(samples), 400):
        engine.take(Samples(samples[begin : begin + 400]))
        frames.append(engine.frames())
    engine.end()
    found = np.concatenate([*frames, engine.frames()])
    whole = model.target.decode(model.predict(None, 30.0, len(found), sound=Sound(samples, RATE)))
    assert engine.rig.controls == ("jawDown", "lipsUp", "noseStill")
    np.testing.assert_allclose(found, whole, atol=2e-3)
    assert np.ptp(found, axis=0)[:2].min() > 0.01
