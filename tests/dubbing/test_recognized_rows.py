"""Rows of a table that name a recording alone: its phones are recognized."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from phonanim.__main__ import run


@pytest.fixture
def table(root: Path, tmp_path: Path) -> Path:
    shutil.copy(root / "examples" / "line.wav", tmp_path / "line.wav")
    path = tmp_path / "lines.csv"
    path.write_text("id,audio\nsaid,line.wav\n", encoding="utf-8")
    return path


def test_a_row_with_a_recording_alone_is_recognized(table: Path, tmp_path: Path) -> None:
    assert run(["batch", str(table), "-o", str(tmp_path / "out"), "--model", "audio", "--format", "csv"]) == 0
    assert (tmp_path / "out" / "said.csv").stat().st_size > 10_000


def test_another_model_says_which_one_recognizes_phones(
    table: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["batch", str(table), "-o", str(tmp_path / "out"), "--format", "csv"]) == 1
    assert "line.wav: is a recording, and this model needs an alignment" in capfd.readouterr().err
