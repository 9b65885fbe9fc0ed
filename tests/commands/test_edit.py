"""`phonanim edit diff` and `phonanim animate --edits`, as an animator uses them."""

import json
import shutil

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.exporters import load, save


@pytest.fixture
def line(root, tmp_path, monkeypatch):
    """The example line in the current folder, animated, and edited: the jaw wider around 2 s."""
    shutil.copy(root / "examples/line.TextGrid", tmp_path)
    monkeypatch.chdir(tmp_path)
    assert run(["animate", "line.TextGrid", "-o", "line.json", "-o", "line.npz", "-o", "line.glb", "-q"]) == 0
    base = load(tmp_path / "line.json")
    values = base.values.copy()
    values[115:125, base.channels.index("jawOpen")] += 0.2
    for name in ("edited.json", "edited.csv", "edited.npz", "edited.glb"):
        save(base.with_values(values), tmp_path / name)
    return tmp_path


@pytest.mark.parametrize(
    ("base", "edited"),
    [
        ("line.json", "edited.json"),
        ("line.json", "edited.csv"),
        ("line.npz", "edited.npz"),
        ("line.glb", "edited.glb"),
    ],
)
@pytest.mark.parametrize("replace", [[], ["--replace"]])
def test_edits_survive_a_new_animation(line, base, edited, replace, capsys):
    assert run(["edit", "diff", base, edited, "-o", "line.edits.json", *replace]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("wrote line.edits.json: 1 edits of 1 channels, ")
    assert run(["animate", "line.TextGrid", "-o", "again.json", "--edits", "line.edits.json", "-q"]) == 0
    again, wanted = load(line / "again.json"), load(line / "edited.json")
    assert np.abs(again.values - wanted.values).max() <= 1e-3 + 1e-6
    assert again.provenance["edits_sha256"]


@pytest.mark.parametrize("suffix", ["usda", "usdc"])
def test_edits_made_in_usd(line, suffix):
    """The weights are changed by the USD library itself, as another program would, and without our notes."""
    usd = pytest.importorskip("pxr.Usd", reason="needs the extra usd")
    skel = pytest.importorskip("pxr.UsdSkel", reason="needs the extra usd")
    base, edited = load(line / "line.json"), load(line / "edited.json")
    for name in (f"base.{suffix}", f"edited.{suffix}"):
        save(base, line / name)
    stage = usd.Stage.Open(str(line / f"edited.{suffix}"))
    prim = stage.GetPrimAtPath("/head/speech")
    prim.ClearCustomData()
    animation = skel.Animation(prim)
    jaw = [str(name) for name in animation.GetBlendShapesAttr().Get()].index("jawOpen")
    for frame in range(115, 125):
        weights = list(animation.GetBlendShapeWeightsAttr().Get(frame))
        weights[jaw] = float(edited.channel("jawOpen")[frame])
        animation.GetBlendShapeWeightsAttr().Set(weights, frame)
    stage.Save()
    assert run(["edit", "diff", f"base.{suffix}", f"edited.{suffix}", "-o", "line.edits.json", "-q"]) == 0
    assert run(["animate", "line.TextGrid", "-o", "again.json", "--edits", "line.edits.json", "-q"]) == 0
    assert np.abs(load(line / "again.json").values - edited.values).max() <= 1e-3 + 1e-6
    assert run(["convert", f"edited.{suffix}", "-o", "back.npz", "-q"]) == 0
    back = load(line / "back.npz")
    np.testing.assert_allclose(back.channel("jawOpen"), edited.channel("jawOpen"), atol=1e-6)


def test_what_does_not_fit_is_told(line, capsys):
    assert run(["edit", "diff", "line.json", "edited.json", "-o", "line.edits.json", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["edits"] == 1
    assert (
        run(["animate", "line.TextGrid", "-o", "again.json", "--rig", "vrm", "--edits", "line.edits.json"])
        == 0
    )
    err = capsys.readouterr().err
    assert "the edits were made on the rig arkit and carried to vrm by what both do to the mouth" in err
    assert "reaches beyond the limits of vrm and was cut there" in err


def test_files_without_phones_are_told(line, capsys):
    save(load(line / "line.json"), line / "line.csv")
    assert run(["edit", "diff", "line.csv", "edited.csv", "-o", "line.edits.json"]) == 0
    assert "neither file holds phones" in capsys.readouterr().err


def test_inputs_are_not_overwritten(line, capsys):
    assert run(["edit", "diff", "line.json", "edited.json", "-o", "edited.json"]) == 2
    assert "edited.json: is named twice" in capsys.readouterr().err
    assert run(["animate", "line.TextGrid", "-o", "edited.json", "--edits", "edited.json"]) == 2
    assert "edited.json: is named twice" in capsys.readouterr().err


def test_a_file_of_no_edits_is_one_line(line, capsys):
    assert run(["animate", "line.TextGrid", "-o", "again.json", "--edits", "edited.json"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (line / "again.json").exists()
