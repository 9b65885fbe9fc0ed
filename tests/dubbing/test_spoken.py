"""Rows with a recording and its text, and no alignment."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import pytest

from phonanim.__main__ import run
from phonanim.dubbing.align_lines import align_line, voice_of
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


def test_text_alone_is_spoken_beside_its_output_and_kept(folder: Path) -> None:
    pytest.importorskip("espeakng_loader", reason="needs the extra espeak")
    (folder / "t.csv").write_text("id,text,voice\na/hi,Guten Morgen,de\nb,My mother moved.,\n")
    assert batch("t.csv") == 0
    made = sorted(path.relative_to(folder / "out").as_posix() for path in (folder / "out").rglob("*.*"))
    assert {"a/hi.csv", "a/hi.wav", "a/hi.aligned.TextGrid", "b.csv", "b.wav"} <= set(made)
    first = {name: (folder / "out" / name).read_bytes() for name in made if name[0] in "ab"}
    facts = [json.loads(line) for line in (folder / "out/ledger.jsonl").read_text().splitlines()]
    assert [entry["facts"]["language"]["name"] for entry in facts] == ["german", "english"]
    assert "eSpeak NG speaks them (de 1, en-us 1)" in (folder / "out/report.json").read_text()
    times = (folder / "out/b.wav").stat().st_mtime_ns
    assert batch("t.csv") == 0
    assert (folder / "out/b.wav").stat().st_mtime_ns == times
    assert run(["audit", "t.csv", "--outputs", "out"]) == 0
    (folder / "out/b.wav").unlink()
    (folder / "t.csv").write_text("id,text,voice\na/hi,Guten Abend,de\nb,My mother moved.,\n")
    assert batch("t.csv") == 0
    assert (folder / "out/b.wav").read_bytes() == first["b.wav"]
    assert (folder / "out/a/hi.wav").read_bytes() != first["a/hi.wav"]


def test_text_alone_is_named_by_its_words_and_takes_the_language(folder: Path) -> None:
    (folder / "t.tsv").write_text("text\tlanguage\nUn, deux et trois!\tfr\n")
    (line,) = read_lines("t.tsv", Common()).lines
    assert (line.id, line.alignment, line.audio, voice_of(line)) == ("Un_deux_et_trois", None, None, "fr")


def test_a_line_that_has_no_recording_yet_is_not_spoken_among_recorded_ones(folder: Path) -> None:
    lines = read_lines(table(folder, ("x", "", "a.wav", TEXT, ""), ("y", "", "", TEXT, "")), Common())
    assert [line.id for line in lines.lines] == ["x"]
    assert "the row names no alignment; fill its cell, or those of audio and text" in lines.faults[0].message


def test_a_voice_that_is_a_recording(folder: Path) -> None:
    (folder / "t.csv").write_text("voice,text\na.wav,hello\n")
    (line,) = read_lines("t.csv", Common()).lines
    assert (line.id, line.audio, line.voice) == ("a", folder / "a.wav", "")


def test_lines_that_are_spoken_are_counted_and_no_flag(folder: Path) -> None:
    pytest.importorskip("espeakng_loader", reason="needs the extra espeak")
    (folder / "t.csv").write_text("id,text\na,My mother moved.\n")
    assert batch("t.csv") == 0
    report = json.loads((folder / "out/report.json").read_text())
    assert report["remarks"] == ["1 of 1 lines have no recording: eSpeak NG speaks them (en-us 1)"]
    assert (report["totals"]["flagged"], report["causes"]) == (0, [])


def test_a_comma_that_parts_a_text_is_a_fault_of_its_row(folder: Path) -> None:
    (folder / "t.csv").write_text("id,text\na,Well, mother moved.\nb,Mother moved.\n")
    found = read_lines("t.csv", Common())
    assert [line.id for line in found.lines] == ["b"]
    assert found.faults[0].message == ("has 3 cells for 2 columns; put a cell that has a ',' in quotes")


def test_a_column_without_a_name_is_not_used(folder: Path) -> None:
    (folder / "t.csv").write_text(",id,text,\n1,a,Mother moved.,\n")
    (line,) = read_lines("t.csv", Common()).lines
    assert (line.id, line.text) == ("a", "Mother moved.")


def test_subtitles_are_aligned_with_their_recording(folder: Path) -> None:
    pytest.importorskip("pocketsphinx")
    (folder / "a.srt").write_text(f"1\n00:00:00,200 --> 00:00:04,600\n{TEXT}\n")
    assert run(["batch", "*.srt", "-o", "out", "--fps", "25", "--workers", "1", "-q"]) == 0
    notes = (folder / "out/report.json").read_text()
    assert "the words of 1 lines are aligned within the time of each" in notes
    assert "share its time by their letters" not in notes
    assert '"father"' in (folder / "out/a.aligned.TextGrid").read_text()
    assert run(["audit", "*.srt", "--outputs", "out"]) == 0
