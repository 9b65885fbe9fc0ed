"""Several speakers in one file, and words with a dictionary, from the command line and from a table."""

from __future__ import annotations

import json
from pathlib import Path

from click.testing import CliRunner, Result

from phonanim.commands.animate import command as animate
from phonanim.commands.batch import command as batch
from phonanim.commands.info import command as info

TIER = '"IntervalTier"\n"{name}"\n0\n1\n3\n0\n0.3\n"sil"\n0.3\n0.6\n"{label}"\n0.6\n1\n"sil"\n'
HEADER = 'File type = "ooTextFile"\nObject class = "TextGrid"\n\n0\n1\n<exists>\n2\n'


def two_speakers(folder: Path) -> Path:
    path = folder / "two.TextGrid"
    tiers = [
        TIER.format(name=f"{who} - phones", label=label) for who, label in (("Ann", "AA1"), ("Bo", "UW1"))
    ]
    path.write_text(HEADER + "".join(tiers))
    return path


def run(command: object, *arguments: object) -> Result:
    return CliRunner().invoke(command, [str(a) for a in arguments])  # type: ignore[arg-type]


def test_the_speaker_decides_what_is_said(tmp_path: Path) -> None:
    path = two_speakers(tmp_path)
    for who in ("Ann", "Bo"):
        done = run(animate, path, "--speaker", who, "-o", tmp_path / f"{who}.npz")
        assert done.exit_code == 0, done.output
    assert (tmp_path / "Ann.npz").read_bytes() != (tmp_path / "Bo.npz").read_bytes()
    asked = run(info, path, "--speaker", "Bo", "--json")
    assert json.loads(asked.stdout)["read"] == "Bo - phones"


def test_words_and_a_dictionary(tmp_path: Path) -> None:
    path = tmp_path / "words.TextGrid"
    words = TIER.format(name="words", label="mama")
    path.write_text(HEADER.replace("\n2\n", "\n1\n") + words)
    (tmp_path / "small.dict").write_text("mama M AA1 M AH0\n")
    done = run(animate, path, "--lexicon", tmp_path / "small.dict", "-o", tmp_path / "a.json")
    assert done.exit_code == 0, done.output
    phones = json.loads((tmp_path / "a.json").read_text())["phones"]
    assert "AA1" in json.dumps(phones)


def test_a_table_has_columns_for_both(tmp_path: Path) -> None:
    two_speakers(tmp_path)
    (tmp_path / "small.dict").write_text("mama M AA1 M AH0\n")
    table = tmp_path / "lines.csv"
    table.write_text("id,alignment,talker,dictionary\na,two.TextGrid,Ann,small.dict\nb,two.TextGrid,Bo,\n")
    first = run(batch, table, "-o", tmp_path / "out", "--format", "npz", "--json")
    assert first.exit_code == 0, first.output
    before = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out").glob("*.npz")}
    assert set(before) == {"a.npz", "b.npz"}
    (tmp_path / "small.dict").write_text("mama M AH0 M AA1\n")
    run(batch, table, "-o", tmp_path / "out", "--format", "npz")
    after = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out").glob("*.npz")}
    assert after["a.npz"] != before["a.npz"]
    assert after["b.npz"] == before["b.npz"]
