"""Texts that make a careless pattern search for hours are read in time that grows with their size."""

from __future__ import annotations

import time
from contextlib import suppress
from pathlib import Path

import pytest

from benchmarks import crafted_patterns
from phonanim.errors import OutputError, PhonanimError
from phonanim.exporters import load
from phonanim.inputs.alignment import read_alignment
from phonanim.rig.names import COPIED
from phonanim.speech.spoken_text import prepare_text

MANY = 100_000  # a search of the square of it takes a minute
SECONDS = 25.0  # of the processor; a slow and busy computer takes eight for the longest of these


@pytest.mark.parametrize(
    "name", [name for name in crafted_patterns.ALIGNMENTS if "million words" not in name]
)
def test_alignments(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crafted_patterns, "MANY", MANY)
    suffix, make = crafted_patterns.ALIGNMENTS[name]
    (tmp_path / suffix).write_text(make())
    began = time.process_time()
    with suppress(PhonanimError):
        read_alignment(tmp_path / suffix)
    assert time.process_time() - began < SECONDS


@pytest.mark.parametrize("name", crafted_patterns.TAKES)
def test_takes(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crafted_patterns, "MANY", MANY)
    suffix, make = crafted_patterns.TAKES[name]
    (tmp_path / suffix).write_text(make())
    began = time.process_time()
    with pytest.raises(OutputError):
        load(tmp_path / suffix)
    assert time.process_time() - began < SECONDS


def test_texts_and_names() -> None:
    began = time.process_time()
    with suppress(PhonanimError):
        prepare_text("http://" + ".,!?" * MANY + "x", "en-us")
    assert COPIED.sub("", "jaw" + ".001" * MANY + "x").endswith("x")
    assert time.process_time() - began < SECONDS


def test_what_the_patterns_find_is_as_before() -> None:
    assert COPIED.sub("", "jawOpen.001.002") == "jawOpen"
    assert COPIED.sub("", "jawOpen_div2") == "jawOpen"
