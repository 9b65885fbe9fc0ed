"""Rigs and models that nobody means to write: each is refused in one line."""

import json
import shutil
from contextlib import suppress

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from phonanim.core.catalog import SHIPPED
from phonanim.errors import ModelError, RigError
from phonanim.regressors import load
from phonanim.rig.read import load_rig

GOOD = "[controls]\na = [0, 0, 1]\nb = [0, 0, 1]\n"


def refused(path, text, message):
    path.write_text(text)
    with pytest.raises(RigError, match=message) as caught:
        load_rig(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name = 3\n" + GOOD, "name must be a text in quotes, not int"),
        ("direct = ['a']\n" + GOOD, "direct must be a text in quotes, not list"),
        ('direct = "/dev/zero"\n' + GOOD, "direct must be the path of a file from the rig's folder"),
        ("stepped = 1\n" + GOOD, "stepped must be true or false, not 1"),
        ("speech = 3\n" + GOOD, "speech must be a list of names"),
        ("speech = [3]\n" + GOOD, "speech must be a list of names"),
        (GOOD + "[at_most]\na = 3\n", r"\[at_most\] must be a table of names"),
        ("shares = 3\n" + GOOD, r"\[shares\] must be a table of names"),
        ("poses = 3\n" + GOOD, r"\[poses\] must hold a table for each pose"),
        (GOOD + "[poses]\nmean = 3\n", r"\[poses\] must hold a table for each pose"),
        ("[controls]\na = [0, 0, inf]\n", r"three numbers, not"),
        ("[controls]\na = [0, 0, 1e300]\n", r"three numbers, not"),
        ("[controls]\na = [0, 0, nan]\n", r"three numbers, not"),
        ("a = " + "[" * 5000, "nested deeper than 64 levels"),
    ],
)
def test_rigs_of_wrong_types(tmp_path, text, message):
    refused(tmp_path / "mine.toml", text, message)


def test_a_rig_that_goes_through_itself(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "t.csv").write_text("from,to,weight\na,a,1\n")
    for name, other in (("one", "two"), ("two", "one"), ("self", "self")):
        (tmp_path / f"{name}.toml").write_text(f'through = "{other}.toml"\ntable = "t.csv"\n{GOOD}')
    for name in ("one.toml", "two.toml", "self.toml"):
        with pytest.raises(RigError, match="goes through itself; name another rig"):
            load_rig(name)


@pytest.mark.parametrize("cell", ["1e300", "nan", "inf", "x"])
def test_tables_of_rigs(tmp_path, cell):
    (tmp_path / "d.csv").write_text(f"hinge,offset,mode1,a\nbase,0,0,0\nh,0,{cell},1\n")
    refused(tmp_path / "mine.toml", f'direct = "d.csv"\n{GOOD}', "not finite, or above|write a number")
    (tmp_path / "d.csv").unlink()
    (tmp_path / "d.csv").symlink_to("/dev/zero")
    refused(tmp_path / "mine.toml", f'direct = "d.csv"\n{GOOD}', "it is a pipe or a device")


@pytest.fixture
def model(tmp_path):
    shutil.copytree(SHIPPED / "default", tmp_path / "m")
    return tmp_path / "m"


def change_card(model, **changes):
    card = json.loads((model / "model.json").read_text())
    (model / "model.json").write_text(json.dumps({**card, **changes}))


@pytest.mark.parametrize(
    "changes",
    [
        {"kind": 3},
        {"kind": ["dnn"]},
        {"config": 3},
        {"config": {"networks": 10**9}},
        {"config": {"networks": 1e9}},
        {"config": {"hidden": [10**9]}},
        {"config": {"reach": -5, "features": "raw"}},
        {"config": {"features": "raw", "reach": 4096}},
        {"config": {"rate": float("inf")}},
        {"inventory": 3},
    ],
)
def test_cards_that_nobody_means(model, changes):
    change_card(model, **changes)
    with pytest.raises(ModelError) as caught:
        load(model)
    assert "\n" not in str(caught.value)


def test_cards_that_are_bombs(model):
    (model / "model.json").write_text("[" * 100_000)
    with pytest.raises(ModelError, match=r"model\.json: cannot be read as a model .*nested deeper"):
        load(model)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("mean", lambda values: values.ravel()),
        ("modes", lambda values: values[:, :3]),
        ("std", lambda values: values[:2]),
        ("indices", lambda values: values[:, None]),
    ],
)
def test_faces_whose_shapes_do_not_match(model, name, change):
    tensors = load_file(model / "face.safetensors")
    save_file({**tensors, name: np.ascontiguousarray(change(tensors[name]))}, model / "face.safetensors")
    with pytest.raises(ModelError, match="do not match|its face has"):
        load(model)


@pytest.mark.parametrize("name", ["std", "modes"])
def test_faces_that_do_not_move(model, name):
    tensors = load_file(model / "face.safetensors")
    save_file({**tensors, name: tensors[name] * 0}, model / "face.safetensors")
    with pytest.raises(ModelError, match="some of its modes move nothing; fetch or train the model again"):
        load(model)


def test_weights_of_other_shapes(model):
    tensors = load_file(model / "weights.safetensors")
    for name, values in tensors.items():
        shapes = (
            values.ravel()[:1],
            np.zeros((0, *values.shape[1:]), values.dtype),
            values.astype("f8")[None],
        )
        for other in shapes:
            save_file({**tensors, name: np.ascontiguousarray(other)}, model / "weights.safetensors")
            with suppress(ModelError):  # and nothing else
                load(model)
