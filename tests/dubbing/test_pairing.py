"""Folders as aligners leave them, and tables as spreadsheets write them."""

from __future__ import annotations

import unicodedata
from pathlib import Path

from textgrid_text import BEAM, WORDS, long_text

from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.pairing import split_files
from phonanim.dubbing.row import Common

GRID = long_text([("words", WORDS), ("phones", BEAM)])


def put(folder: Path, *names: str) -> None:
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(GRID if path.suffix.lower() == ".textgrid" else "beam")


def test_a_corpus_with_its_alignments_is_paired(tmp_path: Path) -> None:
    put(tmp_path, "a/x.TextGrid", "a/x.wav", "a/x.lab", "b/y.textgrid", "b/y.WAV", "b/y.lab")
    lines = read_lines(str(tmp_path), Common())
    assert [(line.id, line.audio and line.audio.name) for line in lines.lines] == [
        ("a/x", "x.wav"),
        ("b/y", "y.WAV"),
    ]
    assert lines.faults == ()
    assert lines.notes == ("2 transcripts (.lab) beside alignments are not lines of their own",)


def test_recordings_with_transcripts_are_lines_of_text(tmp_path: Path) -> None:
    put(tmp_path, "a/x.wav", "a/x.lab")
    (line,) = read_lines(str(tmp_path), Common()).lines
    assert (line.id, line.text, line.alignment.name) == ("a/x", "beam", "x.wav")


def test_labels_with_times_are_alignments(tmp_path: Path) -> None:
    put(tmp_path, "x.wav")
    (tmp_path / "x.lab").write_text("0 2000000 sil\n2000000 3000000 b\n")
    (line,) = read_lines(str(tmp_path), Common()).lines
    assert (line.text, line.alignment.name) == (None, "x.lab")


def test_paths_with_backslashes_and_of_other_composition(tmp_path: Path) -> None:
    composed = unicodedata.normalize("NFC", "takes/caf\u00e9.TextGrid")
    put(tmp_path, unicodedata.normalize("NFD", composed))
    backslashed = composed.replace("/", "\\")
    (tmp_path / "t.csv").write_text(f"alignment\n{backslashed}\n", "utf-8")
    lines = read_lines(str(tmp_path / "t.csv"), Common())
    assert lines.faults == ()
    assert unicodedata.normalize("NFC", lines.lines[0].id) == "caf\u00e9"


def test_a_line_that_names_the_separator(tmp_path: Path) -> None:
    put(tmp_path, "x.TextGrid", "y.TextGrid")
    (tmp_path / "t.csv").write_text("sep=;\nid;alignment;unit\na;x.TextGrid;s\nb;y.TextGrid;miles\n")
    lines = read_lines(str(tmp_path / "t.csv"), Common())
    assert [(line.id, line.options.unit) for line in lines.lines] == [("a", "s")]
    assert [(fault.place, "samples@RATE" in fault.message) for fault in lines.faults] == [
        ("t.csv row 4", True)
    ]


def test_a_plain_text_beside_a_recording_is_its_transcript(tmp_path: Path) -> None:
    for name in ("a.m4a", "b.mp4", "c.wav", "c.TextGrid"):
        put(tmp_path, name)
    for name in ("a.txt", "b.lab", "c.txt", "readme.txt"):
        (tmp_path / name).write_text("Hello there.")
    (tmp_path / "d.wav").touch()
    (tmp_path / "d.txt").write_text("0.0 1.0 hello\n")
    alignments, spoken, _ = split_files(sorted(tmp_path.iterdir()))
    assert alignments == [tmp_path / "c.TextGrid"]
    assert spoken == {tmp_path / "a.m4a": "Hello there.", tmp_path / "b.mp4": "Hello there."}
