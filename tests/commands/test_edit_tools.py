"""From each tool's file to a corrected re-take: written, corrected, read, and done again on a new take."""

import json
import re
import shutil

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.exporters import load, save
from phonanim.rig import load_rig
from phonanim.rig.measures import MEASURES
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

FORMATS = ["anim", "unity.anim", "csv", "metahuman.csv"]
EXPORTS = {"unity.anim": {"keys": 1e-5}}  # every key of the first file is kept
JAW = {"metahuman.csv": "CTRL_expressions_jawOpen"}


@pytest.fixture
def line(root, tmp_path, monkeypatch):
    """The example line, and the same line spoken 15 % slower, in the current folder."""
    shutil.copy(root / "examples/line.TextGrid", tmp_path)
    monkeypatch.chdir(tmp_path)
    assert run(["animate", "line.TextGrid", "-o", "line.json", "--life", "0", "-q"]) == 0
    take = load(tmp_path / "line.json")
    phones = [Interval(p.label, 1.15 * p.start, 1.15 * p.end) for p in take.phones]
    write_textgrid(tmp_path / "again.TextGrid", {"phones": phones}, 1.15 * float(take.times[-1]))
    return tmp_path


def corrected(path, out, channel, first, last):
    """The file with a channel wider by 0.2 from frame to frame, as its program would save it."""
    take = load(path)
    values = take.values.copy()
    values[first:last, take.channels.index(channel)] += 0.2
    save(take.with_values(values), out, **EXPORTS.get(suffix_of(path), {}))


def suffix_of(path):
    return path.name.partition(".")[2]


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_correction_survives_a_slower_take(line, suffix):
    rig = "metahuman" if suffix == "metahuman.csv" else "arkit"
    channel = JAW.get(suffix, "jawOpen")
    options = ["--rig", rig, "--life", "0", "-q"]
    exact = ["--key-tolerance", "0.00001"] if suffix in EXPORTS else []
    assert run(["animate", "line.TextGrid", "-o", f"line.{suffix}", *options, *exact]) == 0
    corrected(line / f"line.{suffix}", line / f"edited.{suffix}", channel, 115, 125)
    files = [f"line.{suffix}", f"edited.{suffix}", "--alignment", "line.TextGrid"]
    assert run(["edit", "diff", *files, "-o", "line.edits.json", "-q"]) == 0
    assert {edit["channel"] for edit in json.loads((line / "line.edits.json").read_text())["edits"]} == {
        channel
    }

    assert run(["animate", "again.TextGrid", "-o", "plain.json", *options]) == 0
    assert run(["animate", "again.TextGrid", "-o", "again.json", "--edits", "line.edits.json", *options]) == 0
    change = load(line / "again.json").channel(channel) - load(line / "plain.json").channel(channel)
    at = np.flatnonzero(change > 0.15) / 60
    assert at.min() == pytest.approx(1.15 * 115 / 60, abs=0.1)
    assert at.max() == pytest.approx(1.15 * 125 / 60, abs=0.1)


def test_a_correction_in_maya_by_hand(line):
    """One key is dragged in the file's own text, as the graph editor of Maya leaves it."""
    assert (
        run(["animate", "line.TextGrid", "-o", "line.anim", "--key-tolerance", "0.002", "--life", "0", "-q"])
        == 0
    )
    text = (line / "line.anim").read_text()
    start = text.index("anim jawOpen jawOpen")
    rows = [m for m in re.finditer(r"^    (\d+) (\S+) linear", text[start:], re.MULTILINE) if int(m[1]) > 100]
    found = rows[0]
    place = start + found.start(2)
    text = text[:place] + f"{float(found[2]) + 0.25:.7g}" + text[place + len(found[2]) :]
    (line / "edited.anim").write_text(text)
    arguments = ["line.anim", "edited.anim", "--alignment", "line.TextGrid", "-o", "line.edits.json"]
    assert run(["edit", "diff", *arguments, "-q"]) == 0
    (edit,) = json.loads((line / "line.edits.json").read_text())["edits"]
    assert max(value for _, value in edit["keys"]) == pytest.approx(0.25, abs=2e-3)


def test_an_edit_is_carried_to_another_rig_and_back(line, capsys):
    corrected(line / "line.json", line / "edited.json", "jawOpen", 115, 125)
    assert run(["edit", "diff", "line.json", "edited.json", "-o", "line.edits.json", "-q"]) == 0
    options = ["--rig", "metahuman", "--life", "0"]
    assert run(["animate", "line.TextGrid", "-o", "plain.npz", *options, "-q"]) == 0
    assert run(["animate", "line.TextGrid", "-o", "m.npz", "--edits", "line.edits.json", *options]) == 0
    err = capsys.readouterr().err
    assert err.count("the edits were made on the rig arkit and carried to metahuman by its table") == 1
    assert err.count("depend on the share of two curves") == 1
    plain, moved = load(line / "plain.npz"), load(line / "m.npz")
    change = moved.channel("CTRL_expressions_jawOpen") - plain.channel("CTRL_expressions_jawOpen")
    assert change[115:125].min() == pytest.approx(0.2, abs=2e-3)

    assert run(["edit", "diff", "plain.npz", "m.npz", "-o", "m.edits.json", "-q"]) == 0
    assert (
        run(["animate", "line.TextGrid", "-o", "back.json", "--edits", "m.edits.json", "--life", "0", "-q"])
        == 0
    )
    wanted = load(line / "edited.json")
    back = load(line / "back.json")
    np.testing.assert_allclose(back.channel("jawOpen"), wanted.channel("jawOpen"), atol=5e-3)


@pytest.mark.parametrize("rig", ["vrm", "oculus15"])
def test_edits_go_to_a_rig_of_mouth_shapes_by_what_they_do_to_the_mouth(line, rig, capsys):
    base = load(line / "line.json")
    values = base.values.copy()
    values[115:125, base.channels.index("jawOpen")] += 0.2
    values[115:125, base.channels.index("browInnerUp")] += 0.2
    values[180:190, base.channels.index("browInnerUp")] += 0.2
    save(base.with_values(values), line / "edited.json")
    assert run(["edit", "diff", "line.json", "edited.json", "-o", "line.edits.json", "-q"]) == 0
    options = ["--rig", rig, "--life", "0"]
    assert run(["animate", "line.TextGrid", "-o", "plain.npz", *options, "-q"]) == 0
    capsys.readouterr()
    assert run(["animate", "line.TextGrid", "-o", "v.npz", "--edits", "line.edits.json", *options]) == 0
    err = capsys.readouterr().err
    assert err.count(f"carried to {rig} by what both do to the mouth, of which it shows jawOpen 100%") == 1
    assert err.count(f"edits of browInnerUp were left out: {rig} has nothing for them") == 1
    plain, moved = load(line / "plain.npz"), load(line / "v.npz")
    jaw = load_rig(rig).mouth.moved[:, MEASURES.index("jaw")]
    names = [names[0] for names in load_rig(rig).mouth.names]
    opened = sum(
        (moved.channel(name) - plain.channel(name)) * millimetres
        for name, millimetres in zip(names, jaw, strict=True)
    )
    # The weights may add up to 1 at most, so all shapes give way, and the edit moves the jaw less.
    assert 0.3 * 0.2 * arkit_jaw() < opened[117:123].mean() < 0.2 * arkit_jaw()
    assert sum(moved.channel(name) for name in names).max() <= 1 + 1e-6
    assert np.abs(opened[:100]).max() < 1e-6


def arkit_jaw():
    """Millimetres that the jaw of the ARKit rig drops at full weight."""
    mouth = load_rig("arkit").mouth
    return mouth.moved[mouth.names.index(("jawOpen",)), MEASURES.index("jaw")]


def test_edits_of_mouth_shapes_go_to_metahuman_and_to_a_rig_of_ones_own(line, root, capsys):
    assert run(["animate", "line.TextGrid", "-o", "v.npz", "--rig", "vrm", "--life", "0", "-q"]) == 0
    corrected(line / "v.npz", line / "edited.npz", "aa", 115, 125)
    assert run(["edit", "diff", "v.npz", "edited.npz", "-o", "v.edits.json", "-q"]) == 0
    rigs = root / "lexicon/rigs"
    own = (rigs / "arkit.toml").read_text().replace('name = "arkit"', 'name = "own"')
    for path in (rigs / "head.glb", *rigs.glob("arkit.*.csv")):
        shutil.copy(path, line)
    (line / "own.toml").write_text(own)
    for rig, jaw in (("metahuman", "CTRL_expressions_jawOpen"), ("own.toml", "jawOpen")):
        options = ["--rig", rig, "--life", "0"]
        assert run(["animate", "line.TextGrid", "-o", "plain.npz", *options, "-q"]) == 0
        capsys.readouterr()
        assert run(["animate", "line.TextGrid", "-o", "m.npz", "--edits", "v.edits.json", *options]) == 0
        assert "by what both do to the mouth, of which it shows aa 100%" in capsys.readouterr().err
        change = load(line / "m.npz").channel(jaw) - load(line / "plain.npz").channel(jaw)
        assert change[117:123].min() > 0.07
        assert np.abs(change[:100]).max() < 1e-6


def test_drawn_mouths_have_nothing_for_edits(line, capsys):
    corrected(line / "line.json", line / "edited.json", "jawOpen", 115, 125)
    assert run(["edit", "diff", "line.json", "edited.json", "-o", "line.edits.json", "-q"]) == 0
    arguments = ["-o", "r.json", "--rig", "rhubarb", "--edits", "line.edits.json"]
    assert run(["animate", "line.TextGrid", *arguments]) == 0
    assert capsys.readouterr().err.count("rhubarb has no such channel") == 1


def test_convert_goes_both_ways(line, capsys):
    assert run(["convert", "line.json", "-o", "m.metahuman.csv", "-o", "line.csv"]) == 0
    assert "converted from the rig arkit to metahuman by its table" in capsys.readouterr().err
    assert (
        run(["convert", "m.metahuman.csv", "-o", "back.csv", "-o", "back.npz", "--rig", "arkit", "-q"]) == 0
    )
    assert load(line / "back.npz").rig == "arkit"
    base, back = load(line / "line.csv"), load(line / "back.csv")
    np.testing.assert_allclose(back.values, base.values, atol=2e-3)
    assert run(["convert", "m.metahuman.csv", "-o", "same.metahuman.csv", "--rig", "metahuman", "-q"]) == 0
    np.testing.assert_array_equal(
        load(line / "same.metahuman.csv").values, load(line / "m.metahuman.csv").values
    )


def test_a_format_of_another_rig_chooses_it(line, capsys):
    assert run(["animate", "line.TextGrid", "-o", "a.metahuman.csv", "--life", "0"]) == 0
    assert "a.metahuman.csv: its format is of the rig metahuman, so it is used" in capsys.readouterr().err
    options = ["--rig", "metahuman", "--life", "0", "-q"]
    assert run(["animate", "line.TextGrid", "-o", "b.metahuman.csv", *options]) == 0
    assert (line / "a.metahuman.csv").read_bytes() == (line / "b.metahuman.csv").read_bytes()
    assert run(["animate", "line.TextGrid", "-o", "a.metahuman.csv", "--rig", "arkit"]) == 2
    assert "choose --rig metahuman" in capsys.readouterr().err
