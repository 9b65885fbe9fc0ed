"""`phonanim rig phones`: what rigs show of a line, beside the bars."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from phonanim.__main__ import run


def test_rigs_beside_one_another(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = str(root / "examples" / "line.TextGrid")
    assert run(["rig", "phones", line, "--rig", "arkit", "--rig", "rhubarb", "--table"]) == 0
    shown = capsys.readouterr().out
    assert "| phone | lip_gap | lip_width |" in shown
    assert "| check | wanted | arkit |" in shown
    assert "rhubarb: own mouth shown by 100% of phones, 100% of p b m f v" in shown


def test_json_has_phones_and_checks(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = str(root / "examples" / "line.TextGrid")
    assert run(["rig", "phones", line, "--rig", "vrm", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["vrm"]
    assert set(found) == {"phones", "checks", "remarks"}
    assert any(remark.startswith("sum of the weights") for remark in found["remarks"])


def test_a_folder_without_alignments_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["rig", "phones", str(tmp_path)]) == 2
    assert "holds no .TextGrid files; give a folder of alignments" in capsys.readouterr().err
