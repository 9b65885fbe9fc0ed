"""Rows with a recording and its text, and no alignment."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import pytest

from phonanim.__main__ import run
from phonanim.dubbing.align_lines import align_line
from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.row import Common
from phonanim.errors import OptionError

TEXT = "My father watched Bob move a cheap blue lamp from the wash room."


@pytest.fixture
def folder(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copy(root / "examples/line.wav", tmp_path / "a.wav")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def table(folder: Path, *rows: tuple[str, ...]) -> str:
    with (folder / "t.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows([("id", "alignment", "audio", "text", "language"), *rows])
    return "t.csv"


def batch(source: str) -> int:
    return run(["batch", source, "-o", "out", "--fps", "25", "--workers", "1", "-q"])


def errors(folder: Path) -> list[str]:
    lines = (folder / "out/ledger.jsonl").read_text().splitlines()
    return [json.loads(line)["error"] for line in lines]


def test_it_is_aligned_once_and_again_when_the_text_changes(folder: Path) -> None:
    pytest.importorskip("pocketsphinx")
    source = table(folder, ("sub/x", "", "a.wav", TEXT, ""))
    assert batch(source) == 0
    grid, curves = folder / "out/sub/x.aligned.TextGrid", folder / "out/sub/x.csv"
    first = grid.read_bytes(), curves.read_bytes()
    assert b"father" in first[0]
    assert run(["audit", source, "--outputs", "out"]) == 0
    times = grid.stat().st_mtime_ns
    assert batch(source) == 0
    assert grid.stat().st_mtime_ns == times
    grid.write_text("damaged")
    assert batch(source) == 0
    assert (grid.read_bytes(), curves.read_bytes()) == first
    table(folder, ("sub/x", "", "a.wav", TEXT.replace("a cheap", "the cheap"), ""))
    assert run(["audit", source, "--outputs", "out"]) == 1
    assert batch(source) == 0
    assert grid.read_bytes() != first[0]


def test_an_alignment_stands_before_the_text(folder: Path, root: Path) -> None:
    shutil.copy(root / "examples/line.TextGrid", folder / "b.TextGrid")
    assert batch(table(folder, ("x", "b.TextGrid", "a.wav", "grzegorz", ""))) == 0
    assert not list((folder / "out").glob("*.TextGrid"))


def test_another_language_is_aligned(folder: Path) -> None:
    pytest.importorskip("espeakng_loader", reason="needs the extra espeak")
    assert batch(table(folder, ("x", "", "a.wav", "Mein Vater sah Bob", "german"))) == 0
    assert "Vater" in (folder / "out/x.aligned.TextGrid").read_text("utf-8")


@pytest.mark.parametrize(
    ("text", "language", "error"),
    [
        ("Guten Tag", "german", r"a\.wav: text in 'german' is aligned by the extra espeak; pip install"),
        ("my father grzegorz", "english", "not in the pronouncing dictionary: 'grzegorz'; spell numbers out"),
    ],
)
def test_without_the_extra_that_pronounces(
    folder: Path, monkeypatch: pytest.MonkeyPatch, text: str, language: str, error: str
) -> None:
    pytest.importorskip("pocketsphinx")
    for module in ("phonanim.dubbing.align_lines", "phonanim.aligners.pocketsphinx"):
        monkeypatch.setattr(f"{module}.can_speak", lambda: False)
    (line,) = read_lines(table(folder, ("x", "", "a.wav", text, language)), Common()).lines
    with pytest.raises(OptionError, match=error):
        align_line(line, folder / "x.TextGrid")
    assert not (folder / "x.TextGrid").exists()


def test_a_table_of_recordings_and_texts_alone(folder: Path) -> None:
    (folder / "t.csv").write_text("wav,transcript\na.wav,hello\n")
    (line,) = read_lines("t.csv", Common()).lines
    assert (line.id, line.text, line.alignment, line.audio) == (
        "a",
        "hello",
        folder / "a.wav",
        folder / "a.wav",
    )
