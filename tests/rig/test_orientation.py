"""Heads in other units, upside down or turned away are told, and never go unnoticed into another program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from animations import line

from phonanim.__main__ import run
from phonanim.errors import RigError
from phonanim.exporters import save
from phonanim.rig.head import load_head
from phonanim.rig.meshes import write_head
from phonanim.rig.orientation import orientation_warnings

BASE = load_head()
TURNS = {
    "upside down": np.diag([-1.0, -1.0, 1.0]),
    "backwards": np.diag([-1.0, 1.0, -1.0]),
    "sideways": np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]]),
    "lying": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
}
SAID = {
    "upside down": "stands upside down; turn it upright (y up), and apply the rotation",
    "backwards": "does not look along z; turn its face to +z, and apply the rotation",
    "sideways": "does not look along z; turn its face to +z, and apply the rotation",
    "lying": "lies along z; turn it upright (y up), and apply the rotation",
}


def scaled(factor):
    return replace(BASE, vertices=BASE.vertices * factor, deltas=BASE.deltas * factor)


def turned(turn):
    return replace(BASE, vertices=BASE.vertices @ turn, deltas=BASE.deltas @ turn)


def test_a_head_as_it_should_be():
    assert orientation_warnings(BASE) == ()
    assert orientation_warnings(scaled(4.0)) == ()  # a giant


@pytest.mark.parametrize("how", TURNS)
def test_turned_heads(how):
    assert orientation_warnings(turned(TURNS[how])) == (SAID[how],)


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (
            100,
            "so it is probably in centimetres, and glTF counts metres; scale it by 0.01, and apply the scale",
        ),
        (3000, "so it is probably in millimetres, and glTF counts metres; scale it by 0.001, and apply"),
        (0.01, "too small to be in metres; scale it up, and apply the scale"),
    ],
)
def test_other_units(factor, said):
    (odd,) = orientation_warnings(scaled(factor))
    assert said in odd


def test_shapes_of_other_names_tell_no_direction():
    strange = replace(turned(TURNS["lying"]), targets=tuple(f"x{n}" for n in range(len(BASE.targets))))
    assert orientation_warnings(strange) == ()


def test_usd_is_not_made_of_them(tmp_path):
    write_head(tmp_path / "cm.glb", scaled(100))
    with pytest.raises(RigError, match=r"cm\.glb: is 45 m high, so it is probably in centimetres"):
        save(line(), tmp_path / "a.usda", character=tmp_path / "cm.glb")
    assert not (tmp_path / "a.usda").exists()
    save(line(), tmp_path / "a.glb", character=tmp_path / "cm.glb")  # passes on what there is


def test_a_rig_fits_them_and_says_so(tmp_path, capsys, monkeypatch):
    pytest.importorskip("scipy", reason="needs the extra train")
    monkeypatch.chdir(tmp_path)
    write_head(tmp_path / "hero.glb", turned(TURNS["upside down"] * 100))
    assert run(["rig", "fit", "hero.glb"]) == 0
    said = capsys.readouterr().err
    assert "hero.glb: is 45 m high, so it is probably in centimetres" in said
    assert (
        "hero.glb: stands upside down; turn it upright (y up), and apply the rotation; its curves are" in said
    )


def test_parts_and_shapes_of_one_name_stay_apart(tmp_path):
    """Two materials of one name, and two shapes that read alike, are prims of their own in USD."""
    doubled = replace(
        BASE,
        parts={"a b": BASE.parts["skin"], "a_b": BASE.parts["tongue"]},
        targets=("jaw Open", "jaw_Open", *BASE.targets[2:]),
    )
    write_head(tmp_path / "two.glb", doubled)
    save(line(), tmp_path / "two.usda", character=tmp_path / "two.glb")
    text = (tmp_path / "two.usda").read_text()
    names = [part.split('"')[1] for part in text.split("def Mesh ")[1:]]
    assert len(set(names)) == len(names) == 2
    for mesh in text.split("def Mesh ")[1:]:
        shapes = [part.split('"')[1] for part in mesh.split("def BlendShape ")[1:]]
        assert len(set(shapes)) == len(shapes) > 0
