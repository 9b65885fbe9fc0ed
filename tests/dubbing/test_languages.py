"""A batch decides by all its lines together what a short line cannot tell; the report says what was read."""

from __future__ import annotations

import json
import re
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
    intervals = [Interval(label, (n + 2) / 10, (n + 3) / 10) for n, label in enumerate(parts)]
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


SIX = {
    "en": ["M AO R N IH NG B AA B", "DH AH K W IH K B R AW N F AA K S", "HH AH L OW"],
    "fr": ["b ɔ̃ ʒ u ʁ m a d a m", "ʒ ə s ɥ i z ɑ̃ ʁ ə t a ʁ", "m ɛ ʁ s i b o k u"],
    "ja": ["o h a y o o g o z a i m a s u", "ch i k a t e ts u n o r i m a sh i t a", "a r i g a t o o"],
    "zh": ["n i3 h ao3 m a5", "w o3 sh iii4 zh ong1 g uo2 r en2", "x ie4 x ie5 n i3"],
    "pl": ["dʑ ɛ ɲ d ɔ b r ɨ", "v ʂ ɨ s t k ɔ v p ɔ ʐ ɔ n d k u", "tʂ ɛ ɕ tɕ"],
    "de": ["ts v aɪ ʊ n t ts v a n ts ɪ ç", "ɪ ç m œ ç t ə n a x h aʊ z ə", "d a ŋ k ə ʃ øː n"],
}
SHORT = "y a m"  # which many languages write


@pytest.mark.parametrize("layout", ["{code}/line{n}", "{code}_line{n}", "scene{n}.{code}"])
def test_each_language_of_a_mixed_batch_decides_for_its_own_lines(tmp_path: Path, layout: str) -> None:
    for code, lines in SIX.items():
        for n, labels in enumerate([*lines, SHORT] if code in ("fr", "ja") else lines):
            path = tmp_path / "lines" / layout.format(code=code, n=n)
            write_line(path.parent, path.name, labels)
    found = languages(made(tmp_path, []))
    names = {
        "en": "english",
        "fr": "french",
        "ja": "japanese",
        "zh": "mandarin",
        "pl": "polish",
        "de": "german",
    }
    assert {line: name for line, name in found.items() if name != names[code_of(line)]} == {}


def code_of(line: str) -> str:
    """The language in the name of a line."""
    return next(code for code in SIX if code in re.split(r"[/_.]", line))


def test_a_line_of_a_mixed_folder_is_in_one_of_its_languages(tmp_path: Path) -> None:
    lines = [labels for code in ("fr", "pl", "de") for labels in SIX[code]]
    found = languages(made(tmp_path, [*lines, SHORT]))
    assert set(found.values()) == {"french", "polish", "german"}  # by itself: Thai, at 53 %


def test_two_unsure_lines_do_not_decide_against_the_batch(tmp_path: Path) -> None:
    for n, labels in enumerate([*SIX["fr"], *SIX["fr"]]):
        write_line(tmp_path / "lines", str(n), labels)
    for n in (1, 2):
        write_line(tmp_path / "lines/more", f"{n}", SHORT)
    found = languages(made(tmp_path, []))
    assert set(found.values()) == {"french"}
