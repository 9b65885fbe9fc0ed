"""A data set of controls becomes a corpus, a model, curves of its own rig, and scores."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import dataset_samples
import numpy as np
import pytest
from motions import made_up_motion

from phonanim import animate
from phonanim.__main__ import run
from phonanim.corpus.motion import load_motion_corpus, save_motion_corpus
from phonanim.exporters import load
from phonanim.pipeline import load_model

pytest.importorskip("torch")
RECIPE = """
kind = "{kind}"
corpus = "corpus"
validation = 0.5
[settings]
{settings}
"""
AUDIO = 'encoder = "mfcc"\nhidden = 8\ndepth = 1\nctc = 0.0\nwindow = 20\nepochs = 2\nrate = 30.0'
SAMPLES = (
    'encoder = "mfcc"\nlatent = 8\nhidden = 8\ndepth = 1\ntimesteps = 20\nsteps = 4\nnoise = "none"\n'
    "window = 20\nbatch = 4\nepochs = 2\nrate = 30.0"
)


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("facegood")
    dataset_samples.facegood(folder)
    assert run(["corpus", "build", str(folder), "--dataset", "facegood", "-o", str(folder / "corpus")]) == 0
    return folder


def trained(corpus: Path, kind: str, settings: str) -> Path:
    recipe = corpus / f"{kind}.toml"
    recipe.write_text(RECIPE.format(kind=kind, settings=settings), "utf-8")
    assert run(["train", str(recipe), "-o", str(corpus / kind)]) == 0
    return corpus / kind


@pytest.fixture(scope="module")
def model(corpus: Path) -> Path:
    return trained(corpus, "phisanet", AUDIO)


def test_a_corpus_keeps_what_the_data_set_has(corpus: Path) -> None:
    found = load_motion_corpus(corpus / "corpus")
    assert (found.kind, found.fps, found.source.data) == ("controls", 30.0, "facegood")
    assert found.source.names == ("jawDown", "lipsUp", "noseStill")
    assert [clip.split for clip in found.clips] == ["train", "train", "validation", "test"]
    given = np.load(corpus / "curves.npz")["take_3"]
    assert np.array_equal(found.frames(3), given.astype(np.float32))
    assert found.times(3)[-1] == pytest.approx((len(given) - 1) / 30)


def test_a_model_of_controls_writes_curves_of_its_rig(corpus: Path, model: Path) -> None:
    curves = animate(corpus / "take_3.wav", model=str(model), fps=25)
    assert curves.rig == "facegood"
    assert curves.channels == ("jawDown", "lipsUp", "noseStill")
    assert curves.fps == 25
    assert curves.values[:, 0].std() > 0
    assert not curves.values[:, 2].any()  # it never moved in training
    assert 0 <= curves.values.min() <= curves.values.max() <= 1
    assert "shows them on a --character" in " ".join(curves.provenance["notes"])
    for out in (corpus / "line.npz", corpus / "line.curves.csv"):
        assert run(["animate", str(corpus / "take_3.wav"), "--model", str(model), "-o", str(out)]) == 0
        assert load(out).channels == curves.channels


def test_no_table_leads_to_another_rig(corpus: Path, model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = [str(corpus / "take_3.wav"), "--model", str(model), "-o", str(corpus / "other.json")]
    assert run(["animate", *line, "--rig", "metahuman"]) == 2
    assert "no table leads from them to the rig metahuman" in capsys.readouterr().err
    assert not (corpus / "other.json").exists()


def test_models_are_scored_beside_a_still_face(
    corpus: Path, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = trained(corpus, "facediffuser", SAMPLES)
    assert load_model(str(other)).target.size == 2
    capsys.readouterr()
    given = ["corpus", "score", str(corpus / "corpus"), "--model", str(model), "--model", str(other)]
    pytest.importorskip("matplotlib")
    heat = corpus / "heat.png"
    assert run([*given, "-o", str(corpus / "scored"), "--heat", str(heat), "--json"]) == 0
    assert heat.read_bytes().startswith(b"\x89PNG")
    facts = json.loads(capsys.readouterr().out)
    assert set(facts["models"]) == {"phisanet", "facediffuser", "mean of training"}
    assert facts["models"]["phisanet"]["control_l2"] > 0
    assert {path.parent.name for path in (corpus / "scored").rglob("*.npz")} == {
        *("phisanet", "facediffuser", "captured"),
    }
    captured = load(corpus / "scored" / "captured" / "take_3.npz")
    assert np.allclose(captured.values, np.load(corpus / "curves.npz")["take_3"], atol=1e-6)


def test_what_a_kind_needs_is_said(corpus: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for kind, settings, why in (
        ("phone_mean", "", "reads phones, and clips of the corpus have none"),
        ("phisanet", AUDIO.replace("ctc = 0.0", "ctc = 0.1"), "ctc needs phones"),
    ):
        recipe = corpus / "wrong.toml"
        recipe.write_text(RECIPE.format(kind=kind, settings=settings), "utf-8")
        assert run(["train", str(recipe), "-o", str(corpus / "wrong")]) == 2
        assert why in capsys.readouterr().err


@pytest.mark.parametrize(
    ("by", "styles"),
    [
        ("speaker", ["anna", "bert"]),
        ("emotion", ["joy", "neutral"]),
        ("speaker and emotion", ["anna joy", "anna neutral", "bert joy", "bert neutral"]),
        ("none", []),
    ],
)
def test_speakers_and_emotions_are_styles(by: str, styles: list[str], tmp_path: Path) -> None:
    folder = made_up_motion("controls", tmp_path)
    corpus = load_motion_corpus(folder / "corpus")
    clips = tuple(
        replace(clip, subject=("anna", "bert")[n % 2], emotion=("joy", "neutral")[n // 2 % 2])
        for n, clip in enumerate(corpus.clips)
    )
    save_motion_corpus(replace(corpus, clips=clips), folder / "corpus")
    recipe = f'kind = "phone_mean"\ncorpus = "corpus"\n[target]\nstyles = "{by}"\n'
    (folder / "recipe.toml").write_text(recipe, "utf-8")
    assert run(["train", str(folder / "recipe.toml"), "-o", str(folder / "model"), "--quiet"]) == 0
    model = load_model(str(folder / "model"))
    assert model.card["styles"] == styles
    assert model.regressor.config.styles == max(len(styles), 1)
