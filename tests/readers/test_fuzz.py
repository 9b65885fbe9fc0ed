"""The script that reads damaged alignment files finds no fault, and would find one."""

from __future__ import annotations

import random
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import fuzz
from phonanim.errors import AlignmentError


@pytest.mark.slow
def test_every_damaged_file_ends_in_a_track_or_in_one_line(root: Path) -> None:
    """In a process of its own: the memory that is measured is that of reading alone."""
    command = [sys.executable, str(root / "benchmarks/fuzz.py"), "--count", "4000", "--seconds", "20"]
    run = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "0 faults" in run.stdout


def test_files_that_grow_when_they_are_read_end_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "words.dict").write_text(fuzz.LEXICON)
    for bomb in fuzz.BOMBS:
        (tmp_path / "x").write_bytes(bomb)
        assert fuzz.fault_of(tmp_path / "x", tmp_path / "words.dict")[1] == ""


def test_the_same_seed_makes_the_same_files() -> None:
    def files(seed: int) -> list[bytes]:
        source = fuzz.mutants(random.Random(seed))
        return [next(source) for _ in range(50)]

    assert files(1) == files(1)
    assert files(1) != files(2)
    assert set(files(1)) - set(fuzz.SEEDS)


@pytest.mark.parametrize(
    ("error", "fault"),
    [
        (ZeroDivisionError("oops"), "ZeroDivisionError: oops"),
        (AlignmentError("a.TextGrid: two\nlines"), "is not one line that names the file"),
        (AlignmentError("no file is named"), "is not one line that names the file"),
        (fuzz.HangError("took more than 10 s"), "HangError: took more than 10 s"),
    ],
)
def test_faults_are_kept_with_their_file(
    error: Exception, fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(path: Path, lexicon: Path) -> None:
        raise error

    monkeypatch.setattr(fuzz, "read_alignment", fail)
    monkeypatch.setattr(fuzz, "BOMBS", [])
    tally = fuzz.fuzz(20, 60.0, 0, tmp_path)
    assert sum(tally.ends.values()) == len(tally.faults) == 20
    assert all(fault in what for what, _ in tally.faults)
    assert len({data for _, data in tally.faults}) > 10


def test_a_file_that_takes_too_long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def loop(path: Path, lexicon: Path) -> None:
        while True:
            pass

    monkeypatch.setattr(fuzz, "read_alignment", loop)
    monkeypatch.setattr(fuzz, "BOMBS", [])
    monkeypatch.setattr(fuzz, "HANG", 1)
    tally = fuzz.fuzz(1, 60.0, 0, tmp_path)
    assert "took more than 1 s" in tally.faults[0][0]
