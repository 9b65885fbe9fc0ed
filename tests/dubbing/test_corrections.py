"""Corrections beside the outputs are part of a run, of its ledger and of an audit."""

from dataclasses import replace

import pytest

from phonanim.__main__ import run
from phonanim.animation.correction_file import write_corrections
from phonanim.animation.corrections import Corrections
from phonanim.dubbing.ledger import read_ledger
from phonanim.exporters import load
from phonanim.speech.alignment import Interval
from phonanim.speech.phone_changes import PhoneChanges
from phonanim.speech.textgrid import write_textgrid

READ = (Interval("AA", 0.5, 0.8), Interval("B", 0.8, 0.9), Interval("IY", 0.9, 1.2))
SPOKEN = (READ[0], Interval("D", 0.8, 0.95), Interval("IY", 0.95, 1.2))


@pytest.fixture
def lines(tmp_path):
    (tmp_path / "lines").mkdir()
    (tmp_path / "out").mkdir()
    for name in ("a", "b"):
        write_textgrid(tmp_path / f"lines/{name}.TextGrid", {"phones": READ}, 1.5)
    return tmp_path


def batch(folder, *more):
    given = [str(folder / "lines"), "-o", str(folder / "out"), "--format", "npz", "--fps", "20"]
    return run(["batch", *given, "--workers", "1", "-q", *more])


def audit(folder):
    return run(["audit", str(folder / "lines"), "--outputs", str(folder / "out"), "--workers", "1"])


def test_the_next_run_has_what_was_corrected(lines, capsys):
    assert batch(lines) == 0
    first = read_ledger(lines / "out")
    assert "corrections" not in first["a"].origin
    path = lines / "out/a.corrections.json"
    write_corrections(Corrections(PhoneChanges(READ, SPOKEN), {"jaw": 1.5}), path)
    assert audit(lines) == 1
    assert "stale      a: corrections has changed" in capsys.readouterr().out
    assert batch(lines) == 0
    now = read_ledger(lines / "out")
    assert now["b"].outputs == first["b"].outputs
    assert now["a"].outputs != first["a"].outputs
    made = load(lines / "out/a.npz")
    assert [phone.label for phone in made.phones] == ["", "AA", "D", "IY", ""]
    assert made.provenance["options"]["jaw"] == 1.5
    assert audit(lines) == 0
    path.unlink()
    assert audit(lines) == 1
    assert batch(lines) == 0
    assert read_ledger(lines / "out")["a"].outputs == first["a"].outputs


def test_a_new_alignment_keeps_them_and_tells_what_it_cannot(lines):
    write_corrections(Corrections(PhoneChanges(READ, SPOKEN)), lines / "out/a.corrections.json")
    write_corrections(Corrections(PhoneChanges(READ, SPOKEN)), lines / "out/b.corrections.json")
    slower = tuple(Interval(p.label, 1.15 * p.start, 1.15 * p.end) for p in READ)
    write_textgrid(lines / "lines/a.TextGrid", {"phones": slower}, 1.8)
    write_textgrid(lines / "lines/b.TextGrid", {"phones": [replace(p, label="UW") for p in READ]}, 1.5)
    assert batch(lines) == 0
    made = load(lines / "out/a.npz")
    assert made.phones[2].end == pytest.approx(1.15 * 0.95)
    other = load(lines / "out/b.npz").provenance["notes"]
    assert any("correction of the phones B IY was left out" in note for note in other)


def test_a_run_into_another_folder_takes_them_from_the_folder_of_edits(lines):
    (lines / "kept").mkdir()
    write_corrections(Corrections(PhoneChanges(READ, SPOKEN)), lines / "kept/a.corrections.json")
    write_corrections(Corrections(PhoneChanges(READ, SPOKEN)), lines / "kept/b.corrections.json")
    write_corrections(
        Corrections(), lines / "out/b.corrections.json"
    )  # what lies beside the outputs is newer
    assert batch(lines, "--edits", str(lines / "kept")) == 0
    labels = {name: [p.label for p in load(lines / f"out/{name}.npz").phones] for name in "ab"}
    assert labels == {"a": ["", "AA", "D", "IY", ""], "b": ["", "AA", "B", "IY", ""]}


def test_an_output_does_not_take_the_place_of_corrections(lines, capsys):
    write_corrections(Corrections(), lines / "out/a.corrections.json")
    write_textgrid(lines / "lines/a.corrections.TextGrid", {"phones": READ}, 1.5)
    given = [str(lines / "lines"), "-o", str(lines / "out"), "--format", "json", "--workers", "1"]
    assert run(["batch", *given]) == 1
    assert "a.corrections.json" in capsys.readouterr().err
    assert "phonanim corrections" in (lines / "out/a.corrections.json").read_text()


def test_damaged_corrections_fail_their_line_alone(lines):
    (lines / "out/a.corrections.json").write_text('{"format": "phonanim corrections 1"')
    assert batch(lines) == 1
    known = read_ledger(lines / "out")
    assert "a.corrections.json: is not a file of corrections" in known["a"].error
    assert known["b"].done
