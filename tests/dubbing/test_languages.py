"""A batch decides by all its lines together what a short line cannot tell; the report says what was read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from phonanim.__main__ import run
from phonanim.dubbing.languages import common_language
from phonanim.dubbing.outcome import Outcome
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

JAPANESE = ["k a w a i i", "o h a y o o", "a r i g a t o o", "y a m", "ch i k a t e ts u"]


def write_line(folder: Path, name: str, labels: str) -> None:
    """A TextGrid with silence, the labels, a tenth of a second each, and silence."""
    folder.mkdir(parents=True, exist_ok=True)
    parts = labels.split()
    intervals = [Interval(label, 0.2 + n / 10, 0.3 + n / 10) for n, label in enumerate(parts)]
    write_textgrid(folder / f"{name}.TextGrid", {"phones": intervals}, 0.4 + len(parts) / 10)


def made(folder: Path, lines: list[str], *options: str) -> dict[str, Any]:
    """The report of a batch of lines, "0", "1" and so on; files that are there already are kept."""
    for number, labels in enumerate(lines):
        write_line(folder / "lines", str(number), labels)
    fixed = ["--format", "csv", "--workers", "1", "--fps", "25", "-q"]
    assert run(["batch", str(folder / "lines"), "-o", str(folder / "out"), *fixed, *options]) == 0
    document: dict[str, Any] = json.loads((folder / "out/report.json").read_text("utf-8"))
    return document


def languages(document: dict[str, Any]) -> dict[str, str]:
    """The language of each line."""
    return {line["id"]: line["facts"]["language"]["name"] for line in document["lines"]}


def test_most_lines_decide_on_one_that_cannot_tell(tmp_path: Path) -> None:
    alone = made(tmp_path / "alone", JAPANESE[3:4])
    assert [flag["check"] for flag in alone["lines"][0]["facts"]["flags"]] == ["language"]
    document = made(tmp_path, [*JAPANESE, "M AO R N IH NG"])
    assert document["totals"]["languages"] == {"english": 1, "japanese": 5}
    assert document["totals"]["flagged"] == 0
    page = (tmp_path / "out/report.html").read_text("utf-8")
    assert "<td>japanese (" in page
    assert "language: english 1, japanese 5" in page


def test_a_decided_line_is_kept_until_the_others_change(tmp_path: Path) -> None:
    made(tmp_path, JAPANESE)
    before = (tmp_path / "out/3.csv").stat().st_mtime_ns
    assert languages(made(tmp_path, []))["3"] == "japanese"
    assert (tmp_path / "out/3.csv").stat().st_mtime_ns == before
    french = ["b ɔ̃ ʒ u ʁ", "s a l y", "m ɛ ʁ s i b o k u", "y a m", "ʒ ə s ɥ i z ɑ̃ ʁ ə t a ʁ"]
    assert languages(made(tmp_path, french))["3"] == "french"
    assert (tmp_path / "out/3.csv").stat().st_mtime_ns != before


def test_a_named_language_is_not_outvoted(tmp_path: Path) -> None:
    rows = [f"{n},lines/{n}.TextGrid,{'fr' if n == 3 else ''}" for n in range(len(JAPANESE))]
    for number, labels in enumerate(JAPANESE):
        write_line(tmp_path / "lines", str(number), labels)
    (tmp_path / "t.csv").write_text("\n".join(["id,alignment,language", *rows]), "utf-8")
    fixed = ["--format", "csv", "--workers", "1", "--fps", "25", "-q"]
    assert run(["batch", str(tmp_path / "t.csv"), "-o", str(tmp_path / "out"), *fixed]) == 0
    document = json.loads((tmp_path / "out/report.json").read_text("utf-8"))
    assert languages(document)["3"] == "french"


def test_a_fallback_language_flags_no_line(tmp_path: Path) -> None:
    document = made(tmp_path, ["b a t a", "m i k a"], "--language", "hausa", "--fallback-language", "ipa")
    assert document["totals"]["flagged"] == 0
    assert "<td>ipa (there is no hausa)</td>" in (tmp_path / "out/report.html").read_text("utf-8")


def told(**candidates: float) -> Outcome:
    """A line whose labels may be in these languages."""
    facts = {"language": {"name": "x", "by": "labels", "certainty": 1.0, "candidates": candidates}}
    return Outcome("x", "x", facts=facts)


@pytest.mark.parametrize(
    ("lines", "name"),
    [
        ([told(japanese=1.0)], ""),
        ([told(japanese=1.0), told(japanese=0.3, french=0.7)], "japanese"),
        ([told(japanese=1.0), told(french=1.0)], ""),
        ([told(japanese=0.6, french=0.4), told(japanese=0.6, english=0.4)], "japanese"),
        ([], ""),
    ],
)
def test_the_language_of_most_lines(lines: list[Outcome], name: str) -> None:
    assert common_language(lines) == name
