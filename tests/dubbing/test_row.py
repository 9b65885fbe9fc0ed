"""What the cells of a row say, and what a run makes of it: characters, edits, overlays, timecodes."""

import json
import shutil

import numpy as np
import pytest
from ledgers import plain_ledger

from phonanim.__main__ import run
from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.row import Common
from phonanim.exporters import load
from phonanim.exporters.npz import write as write_npz
from phonanim.media.glb import read_glb
from phonanim.options import Options, Overlay
from phonanim.rig.head import SHIPPED
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

FAST = ["--fps", "25", "--workers", "1"]
PHONES = [Interval("AA", 0.5, 0.8), Interval("B", 0.8, 0.9), Interval("IY", 0.9, 1.2)]


@pytest.fixture
def folder(tmp_path, monkeypatch, root):
    """Two lines, a character and a pose, in the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(root))
    for name in ("a", "b"):
        write_textgrid(tmp_path / f"{name}.TextGrid", {"phones": PHONES}, 1.5)
    shutil.copy(SHIPPED, tmp_path / "hero.glb")
    (tmp_path / "brow.toml").write_text("browInnerUp = 0.5\n")
    return tmp_path


def table(folder, text):
    (folder / "t.csv").write_text(text, "utf-8")
    return "t.csv"


def batch(*arguments):
    return run(["batch", *map(str, arguments), *FAST])


def statuses(capsys):
    events = map(json.loads, capsys.readouterr().out.splitlines())
    return [event["status"] for event in events if event["event"] == "line"]


def test_cells(folder):
    (folder / "a.edits.json").write_text("")
    source = table(
        folder,
        "alignment,Character,Edit,Overlays,Smoothing,Gains,TC,Pitch\n"
        "a.TextGrid,hero.glb,a.edits.json,smile=0.5@1-2; brow.toml,"
        "8Hz,jawOpen=1.2;mouthPucker=0.8,01:00:00:00,praat\n"
        "b.TextGrid,metahuman,,,0.1,,,\n",
    )
    first, second = read_lines(source, Common(exports={"keys": 0.01})).lines
    assert first.exports == {"keys": 0.01, "character": folder / "hero.glb", "timecode": "01:00:00:00"}
    assert first.edits == folder / "a.edits.json"
    assert first.options.overlays == (
        Overlay("smile", 0.5, (1.0, 2.0)),
        Overlay(str(folder / "brow.toml"), 1.0, None),
    )
    assert first.options.gains == {"jawOpen": 1.2, "mouthPucker": 0.8}
    assert 0.0 < first.options.smooth < 0.1
    assert first.options.rig == Options().rig
    assert (first.options.pitch, second.options.pitch) == ("praat", "builtin")
    assert (second.options.rig, second.options.smooth) == ("metahuman", 0.1)
    assert second.exports == {"keys": 0.01}


@pytest.mark.parametrize(
    ("columns", "cells", "message"),
    [
        ("character", "gone.glb", "gone.glb: does not exist; correct the path"),
        (
            "character,rig",
            "metahuman,arkit",
            "character = 'metahuman' and rig = 'arkit' both name a rig; give one",
        ),
        ("edits", "gone.json", "gone.json: does not exist; correct the path"),
        ("overlay", "gone.toml", "gone.toml: does not exist; correct the path"),
        ("overlay", "smile=9", "smile = '9'; give a number from 0 to 4"),
        ("overlay", "smile@2-1", "smile@2-1: its span must end after it starts"),
        ("overlay", ";", "an overlay names no file; write FILE=GAIN@START-END"),
        ("smooth", "much", "'much' is neither 0 to 1 seconds nor a rate such as 8Hz"),
        ("gain", "jawOpen", "'jawOpen' is not CONTROL=NUMBER, such as jawOpen=1.2"),
        ("pitch", "prat", "pitch = 'prat'; choose builtin or praat"),
        ("lexicon", "gone.dict", "gone.dict: does not exist; correct the path"),
    ],
)
def test_cells_of_no_use(folder, columns, cells, message):
    (fault,) = read_lines(table(folder, f"alignment,{columns}\na.TextGrid,{cells}\n"), Common()).faults
    assert message in fault.message


def test_a_character_speaks(folder, capsys):
    source = table(folder, "id,alignment,character\nx,a.TextGrid,hero.glb\ny,b.TextGrid,\n")
    assert batch(source, "-o", "out", "--format", "glb", "--key-tolerance", "0.01", "-q") == 0
    options = ["--fps", "25", "--character", "hero.glb", "--key-tolerance", "0.01", "-q"]
    assert run(["animate", "a.TextGrid", "-o", "x.glb", *options]) == 0
    assert (folder / "out/x.glb").read_bytes() == (folder / "x.glb").read_bytes()

    assert batch(source, "-o", "out", "--format", "glb", "--key-tolerance", "0.01", "--json") == 0
    assert statuses(capsys) == ["kept", "kept"]
    glb = read_glb(folder / "hero.glb")
    (folder / "hero.glb").write_bytes(remade(glb))
    assert batch(source, "-o", "out", "--format", "glb", "--key-tolerance", "0.01", "--json") == 0
    assert sorted(statuses(capsys)) == ["kept", "made"]  # another character of the same name


def remade(glb):
    from phonanim.media.glb import glb_bytes

    return glb_bytes({**glb.tree, "asset": {**glb.tree["asset"], "copyright": "nobody"}}, glb.binary)


def test_options_that_no_format_has(folder, capsys):
    assert batch("*.TextGrid", "-o", "out", "--format", "csv", "--character", "hero.glb") == 2
    assert "--character does nothing for csv; leave it out" in capsys.readouterr().err
    assert not (folder / "out").exists()
    source = table(folder, "id,alignment,character\nx,a.TextGrid,hero.glb\ny,b.TextGrid,\n")
    assert batch(source, "-o", "out", "--format", "csv") == 1
    assert "a.TextGrid: character has no effect on x.csv; leave it out" in capsys.readouterr().err
    assert (folder / "out/y.csv").exists()


def test_timecodes(folder):
    source = table(
        folder, "id,alignment,timecode\nx,a.TextGrid,02:00:00:00\ny,b.TextGrid,\nz,a.TextGrid,soon\n"
    )
    assert batch(source, "-o", "out", "--timecode", "01:00:00:00", "-q") == 1
    firsts = [(folder / f"out/{name}.csv").read_text().splitlines()[1][:11] for name in ("x", "y")]
    assert firsts == ["02:00:00:00", "01:00:00:00"]
    report = json.loads((folder / "out/report.json").read_text())
    assert "soon" in report["lines"][0]["error"]


def test_edits_of_a_folder(folder, capsys):
    """An animator opens the mouth in line a; every new run keeps that."""
    options = ["--format", "npz", "-q"]
    assert batch("*.TextGrid", "-o", "out", *options) == 0
    base = load(folder / "out/a.npz")
    values = base.values.copy()
    values[10:20, base.channels.index("jawOpen")] += 0.25
    write_npz(base.with_values(values), folder / "edited.npz")
    (folder / "edits").mkdir()
    assert run(["edit", "diff", "out/a.npz", "edited.npz", "-o", "edits/a.edits.json", "-q"]) == 0
    shutil.copy("edits/a.edits.json", "edits/other.edits.json")

    capsys.readouterr()
    assert batch("*.TextGrid", "-o", "out", "--format", "npz", "--edits", "edits", "--json") == 0
    assert sorted(statuses(capsys)) == ["kept", "made"]
    again = load(folder / "out/a.npz")
    assert np.abs(again.values - values).max() < 2e-3
    report = json.loads((folder / "out/report.json").read_text())
    assert report["remarks"] == [f"{folder}/edits/other.edits.json: belongs to no line"]

    (folder / "edits/a.edits.json").write_text("{}")
    assert batch("*.TextGrid", "-o", "out", *options, "--edits", "edits") == 1
    assert "a.edits.json: is not a file of edits" in (folder / "out/summary.txt").read_text()


@pytest.mark.parametrize("option", ["--overlay", "--lexicon"])
def test_the_content_of_shared_files_counts(folder, capsys, option):
    file = {"--overlay": "brow.toml", "--lexicon": "words.dict"}[option]
    (folder / "words.dict").write_text("a AA\n")
    for text, status in [("", "made"), ("", "kept"), ("\n", "made")]:
        (folder / file).write_text((folder / file).read_text() + text)
        assert batch("a.*", "-o", "out", option, file, "--json") == 0
        assert statuses(capsys) == [status]


def test_outputs_do_not_tell_where_files_lay(folder):
    (folder / "deep").mkdir()
    shutil.copy("brow.toml", "deep/brow.toml")
    for out, file in [("one", "brow.toml"), ("two", "deep/brow.toml")]:
        assert batch("a.*", "-o", out, "--format", "npz", "--overlay", file, "--smooth", "0.05", "-q") == 0
    assert (folder / "one/a.npz").read_bytes() == (folder / "two/a.npz").read_bytes()
    ledgers = [(folder / name / "ledger.jsonl").read_bytes() for name in ("one", "two")]
    assert plain_ledger(ledgers[0]) == plain_ledger(ledgers[1])


def test_a_language_that_nobody_wrote(folder):
    write_textgrid(folder / "h.TextGrid", {"phones": [Interval("ɓ", 0.5, 0.6), Interval("a", 0.6, 0.9)]}, 1.5)
    source = table(folder, "id,alignment,language\nx,a.TextGrid,english\ny,h.TextGrid,hausa\n")
    assert batch(source, "-o", "out", "-q") == 1
    (line, _) = json.loads((folder / "out/report.json").read_text())["lines"]
    assert (line["id"], line["place"]) == ("y", "t.csv row 3")
    assert 'there is no language "hausa"; nearest: ' in line["error"]
    assert batch(source, "-o", "out", "-q", "--fallback-language", "ipa") == 0
    lines = json.loads((folder / "out/report.json").read_text())["lines"]
    facts = next(line["facts"] for line in lines if line["id"] == "y")
    assert facts["flags"] == []
    assert facts["language"] == {"name": "ipa", "by": "fallback", "certainty": 1.0, "asked": "hausa"}


def test_rigs_and_models_of_ones_own(folder, tmp_path):
    from phonanim.core.catalog import find_model
    from phonanim.rig.read import find_rig

    (folder / "show").mkdir()
    for name in ("a.TextGrid", "brow.toml"):
        shutil.copy(name, folder / "show")
    shutil.copytree(find_rig("arkit").parent, folder / "show/rigs")
    shutil.copytree(find_model("default"), folder / "show/own")
    (folder / "show/t.csv").write_text(
        "alignment,rig,model,overlay\na.TextGrid,rigs/arkit.toml,own,smile=0.5\n"
    )
    assert batch("show/t.csv", "-o", "out", "--format", "npz", "-q") == 0
    options = [
        "--fps",
        "25",
        "--rig",
        "show/rigs/arkit.toml",
        "--model",
        "show/own",
        "--overlay",
        "smile=0.5",
        "-q",
    ]
    assert run(["animate", "show/a.TextGrid", "-o", "a.npz", *options]) == 0
    assert (folder / "out/a.npz").read_bytes() == (folder / "a.npz").read_bytes()
    assert run(["audit", "show/t.csv", "--outputs", "out", "-q"]) == 0
