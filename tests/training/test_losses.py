"""The picture of a training's losses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from speech import made_up_examples

from phonanim.__main__ import run
from phonanim.commands.train import command
from phonanim.errors import MissingExtraError
from phonanim.regressors import make_config, regressor_class
from phonanim.training.losses import check_drawable, draw_losses

CURVE = "epoch,training_loss,validation_mm2\n1,0.9,19.4\n2,0.5,17.3\n3,0.4,17.9\n"


def test_every_curve_of_a_folder_is_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="needs the extra plots")
    for name in ("model", "model/autoencoder"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "loss.csv").write_text(CURVE)
    pictures = draw_losses(tmp_path / "model")
    assert pictures == [tmp_path / "model/autoencoder/loss.png", tmp_path / "model/loss.png"]
    first = [path.read_bytes() for path in pictures]
    assert first[0].startswith(b"\x89PNG")
    assert [path.read_bytes() for path in draw_losses(tmp_path / "model")] == first
    (tmp_path / "model/loss.csv").write_text(CURVE.replace("17.9", "16.9"))
    assert draw_losses(tmp_path / "model")[1].read_bytes() != first[1]


def test_a_training_of_one_epoch_has_a_picture(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="needs the extra plots")
    (tmp_path / "loss.csv").write_text("".join(CURVE.splitlines(keepends=True)[:2]))
    assert draw_losses(tmp_path) == [tmp_path / "loss.png"]
    assert draw_losses(tmp_path / "nowhere") == []


def test_without_matplotlib(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'phonanim\[plots\]', or leave out --plot"):
        check_drawable("two_stage", tmp_path)


def test_a_kind_that_keeps_no_losses_is_refused_before_it_is_trained(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib", reason="needs the extra plots")
    recipe = tmp_path / "small.toml"
    recipe.write_text('kind = "tree"\ncorpus = "nowhere"\n')
    assert run(["train", str(recipe), "--plot"]) == 2
    assert (
        "small.toml: a training of 'tree' saves no losses to draw; leave out --plot"
        in capsys.readouterr().err
    )


def test_the_command_draws_what_was_trained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib", reason="needs the extra plots")
    recipe, folder = tmp_path / "small.toml", tmp_path / "model"
    recipe.write_text('kind = "phisanet"\ncorpus = "nowhere"\n')
    folder.mkdir()
    (folder / "loss.csv").write_text(CURVE)
    (folder / "model.json").write_text("{}")
    monkeypatch.setattr("phonanim.training.recipes.train", lambda config, **more: folder)
    done = CliRunner().invoke(command, [str(recipe), "--plot"])
    assert done.exit_code == 0, done.output
    assert (folder / "loss.png").is_file()
    assert "loss.png" in done.output


@pytest.mark.parametrize("kind", ["two_stage", "phisanet", "cnn", "tcn"])
def test_audio_driven_models_keep_their_losses(kind: str, tmp_path: Path) -> None:
    pytest.importorskip("torch", reason="needs the extra train")
    data = made_up_examples(np.random.default_rng(5), clips=2)
    settings = make_config(kind, {"encoder": "mfcc", "hidden": 8, "depth": 1, "epochs": 2}, "test")
    fit: Any = regressor_class(kind).fit
    fit(settings, data, data, np.random.default_rng(1), lambda done: None, journal=tmp_path)
    lines = (tmp_path / "loss.csv").read_text().splitlines()
    assert [line.split(",")[0] for line in lines] == ["epoch", "1", "2"]
