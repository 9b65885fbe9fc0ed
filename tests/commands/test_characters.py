"""The commands follow the names of a character, and say once what it leaves unmoved."""

from __future__ import annotations

from pathlib import Path

import pytest
from conventions import write_convention

from phonanim.__main__ import run
from phonanim.exporters import load


@pytest.fixture
def vroid(tmp_path: Path) -> Path:
    return write_convention("VRoid", tmp_path / "vroid.glb")


def test_the_rig_follows_the_character_unless_it_is_chosen(tmp_path, vroid, root, capsys):
    line, made = root / "examples" / "line.TextGrid", tmp_path / "made.glb"
    assert run(["animate", str(line), "-o", str(made), "--character", str(vroid)]) == 0
    said = capsys.readouterr().err
    assert f"{vroid}: has shapes for 100% of 5 mouth controls of the rig vrm, so it is used" in said
    assert f"{vroid}: 3 of 8 shapes have no control: Fcl_EYE_Close, Fcl_EYE_Close_L" in said
    assert load(made).channel("Fcl_MTH_A").max() > 0.5
    assert run(["animate", str(line), "-o", str(made), "--character", str(vroid), "--rig", "arkit"]) == 2
    assert "or give their names as --names" in capsys.readouterr().err


def test_names_of_ones_own_move_the_character(tmp_path, vroid, root, capsys):
    line, made, table = root / "examples" / "line.TextGrid", tmp_path / "made.glb", tmp_path / "own.csv"
    table.write_text("shape,control,weight\nFcl_MTH_A,jawOpen,0.8\n", "utf-8")
    arguments = ["animate", str(line), "-o", str(made), "--character", str(vroid), "--rig", "arkit"]
    assert run([*arguments, "--names", str(table)]) == 0
    assert "15 of 16 mouth controls have no shape: mouthClose, " in capsys.readouterr().err
    taken = load(made)
    assert taken.channel("Fcl_MTH_A").max() > 0.1
    assert not taken.channel("Fcl_MTH_O").any()
    table.write_text("control\njawOpen\n", "utf-8")
    assert run([*arguments, "--names", str(table)]) == 2
    assert "own.csv: cannot be read as a table of names: it has no column 'shape'" in capsys.readouterr().err


def test_a_batch_says_it_once(tmp_path, vroid, root, capsys):
    folder = tmp_path / "lines"
    folder.mkdir()
    for name in ("a", "b"):
        (folder / f"{name}.TextGrid").write_bytes((root / "examples" / "line.TextGrid").read_bytes())
    out = tmp_path / "out"
    arguments = ["batch", str(folder), "-o", str(out), "--format", "glb", "--character", str(vroid)]
    assert run([*arguments, "--workers", "1", "--fps", "10"]) == 0
    assert capsys.readouterr().err.count("3 of 8 shapes have no control") == 1
    assert load(out / "a.glb").channel("Fcl_MTH_A").max() > 0.5


def test_names_of_ones_own_move_the_lines_of_a_batch(tmp_path, vroid, root, capsys):
    """In the processes of the workers too; a line is made again when the table changes."""
    folder, out, table = tmp_path / "lines", tmp_path / "out", tmp_path / "own.csv"
    folder.mkdir()
    (folder / "a.TextGrid").write_bytes((root / "examples" / "line.TextGrid").read_bytes())
    table.write_text("shape,control,weight\nFcl_MTH_A,jawOpen,0.8\n", "utf-8")
    arguments = ["batch", str(folder), "-o", str(out), "--format", "glb", "--character", str(vroid)]
    arguments += ["--rig", "arkit", "--fps", "10", "--workers", "1", "--names", str(table), "--json"]
    assert run(arguments) == 0
    first = load(out / "a.glb")
    assert first.channel("Fcl_MTH_A").max() > 0.1
    assert run(arguments) == 0
    assert '"kept"' in capsys.readouterr().out
    table.write_text("shape,control,weight\nFcl_MTH_A,jawOpen,0.4\n", "utf-8")
    assert run(arguments) == 0
    halved = load(out / "a.glb").channel("Fcl_MTH_A").max() / first.channel("Fcl_MTH_A").max()
    assert halved == pytest.approx(0.5, abs=0.01)
