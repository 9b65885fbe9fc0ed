"""`phonanim convert` as it is used, and the options of formats on every command that has them."""

import json
from dataclasses import replace

import numpy as np
import pytest
from animations import line, only
from avatars import write_vrm1

from benchmarks.hostile import small_character
from phonanim.__main__ import run
from phonanim.exporters import load, save
from phonanim.media.glb import read_glb
from phonanim.rig.head import SHIPPED


@pytest.fixture
def take(tmp_path, monkeypatch):
    """A take in the current folder."""
    monkeypatch.chdir(tmp_path)
    save(line(), tmp_path / "take.npz")
    return tmp_path


def test_one_take_to_several_formats(take, capsys):
    outputs = ("take.csv", "take.glb", "take.html", "take.anim", "take.tsv")
    arguments = [part for name in outputs for part in ("-o", name)]
    assert run(["convert", "take.npz", *arguments, "--contact-sheet", "take.png", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["frames"], facts["fps"], facts["channels"]) == (61, 60.0, 55)
    assert [output["path"] for output in facts["outputs"]] == [*outputs, "take.png"]
    np.testing.assert_allclose(load(take / "take.glb").values, line().values, atol=1e-6)


def test_what_a_character_cannot_show_is_said_once(take, capsys):
    write_vrm1(take / "mine.vrm")
    outputs = ["-o", "a.glb", "-o", "a.vrm", "-o", "a.vrma", "-o", "a.tres"]
    assert run(["convert", "take.npz", *outputs, "--character", "mine.vrm"]) == 0
    told = capsys.readouterr().err
    assert "\na.vrm: a glTF viewer plays it; " in told
    assert "\na.vrma: 50 of 52 moving controls have no expression: browDownLeft, " in told
    assert "no bone called head" not in told


def test_a_character_without_a_head_bone(take, capsys):
    (take / "one.glb").write_bytes(small_character())
    assert run(["convert", "take.npz", "-o", "a.glb", "--character", "one.glb"]) == 0
    assert "\none.glb: has no bone called head, so the head does not turn\n" in capsys.readouterr().err


def test_another_rate_start_and_timecode(take):
    options = ["--fps", "29.97", "--start", "2", "--timecode", "01:00:00;00"]
    assert run(["convert", "take.npz", "-o", "a.npz", "-o", "a.csv", *options, "-q"]) == 0
    animation = load(take / "a.npz")
    assert animation.fps == 30000 / 1001
    assert animation.start == 2.0
    assert len(animation.values) == 30
    assert (take / "a.csv").read_text().splitlines()[1].startswith("01:00:01;59.880")


def test_drop_frame_timecode_is_not_for_unreal(take, capsys):
    said = "\na.csv: Unreal's importer reads no drop-frame timecode; write colons for Unreal\n"
    assert run(["convert", "take.npz", "-o", "a.csv", "--timecode", "01:00:00;00"]) == 0
    assert said in capsys.readouterr().err
    assert run(["convert", "a.csv", "-o", "a.json"]) == 0  # which has no timecode
    assert "drop-frame" not in capsys.readouterr().err
    assert run(["convert", "take.npz", "-o", "a.csv", "--timecode", "01:00:00:00"]) == 0
    assert "drop-frame" not in capsys.readouterr().err


def test_labels_for_a_capture(take, root):
    save(replace(line(), phones=(), words=()), take / "capture.csv")
    grid = str(root / "examples" / "line.TextGrid")
    assert run(["convert", "capture.csv", "-o", "a.npz", "--alignment", grid, "--rig", "mine", "-q"]) == 0
    animation = load(take / "a.npz")
    assert len(animation.phones) > 20
    assert len(animation.words) > 5
    assert animation.rig == "mine"


def test_keys_are_reported(take, capsys):
    assert run(["convert", "take.npz", "-o", "a.glb", "-o", "a.anim", "--key-tolerance", "0.05"]) == 0
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "read take.npz: 61 frames at 60 fps, 55 channels"
    assert said[2].startswith("a.glb: ")
    assert "keys that all curves share" in said[2]
    assert "moving curves" in said[3]


def test_a_character_of_ones_own(take):
    save(only(line(), jawOpen=0.5), take / "mine.glb", character=SHIPPED)
    assert run(["convert", "take.npz", "-o", "a.glb", "--character", "mine.glb", "-q"]) == 0
    assert [a["name"] for a in read_glb(take / "a.glb").tree["animations"]] == ["mine", "a"]


def test_two_takes_on_one_page(take):
    save(only(line(), jawOpen=0.5), take / "second.npz")
    assert run(["convert", "take.npz", "-o", "a.html", "--compare-with", "second.npz", "-q"]) == 0
    page = (take / "a.html").read_text("utf-8")
    assert page.count('"targets":') == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["take.npz"], "nothing to write: name a file with -o, or a picture with --contact-sheet"),
        (["take.npz", "-o", "take.npz"], "take.npz: is named twice, as input or output"),
        (["take.npz", "-o", "a.xyz"], "a.xyz: no format has this suffix"),
        (
            ["take.npz", "-o", "a.csv", "--key-tolerance", "0.1"],
            "--key-tolerance does nothing for a.csv; leave it out",
        ),
        (["take.npz", "-o", "b.npz", "--compare-with", "b.npz"], "b.npz: is named twice, as input or output"),
        (
            ["take.npz", "-o", "a.csv", "--compare-with", "b.npz"],
            "--compare-with does nothing for a.csv; leave it out",
        ),
        (["take.npz", "-o", "a.glb", "--key-tolerance", "-1"], "-1"),
        (["take.npz", "-o", "a.csv", "--timecode", "1h"], "'1h' is not a timecode at 60 frames per second"),
        (["take.npz", "-o", "a.csv", "--fps", "0"], "frames per second"),
        (["none.npz", "-o", "a.csv"], "none.npz"),
        (
            ["a.tsv", "-o", "a.csv"],
            "a.tsv: this format can only be written; readable formats: .a2f.json .anim .csv",
        ),
        (["broken.glb", "-o", "a.csv"], "broken.glb: is not a binary glTF 2.0 file"),
    ],
)
def test_what_cannot_be_converted(take, capsys, arguments, message):
    save(line(), take / "b.npz")
    (take / "a.tsv").write_text("0.00\tX\n")
    (take / "broken.glb").write_bytes(b"glTF")
    before = sorted(path.name for path in take.iterdir())
    assert run(["convert", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert err.count("\n") == 1
    assert sorted(path.name for path in take.iterdir()) == before


def test_animate_takes_the_options_of_formats(take, root):
    grid = str(root / "examples" / "line.TextGrid")
    formats = ["--character", str(SHIPPED), "--key-tolerance", "0.02"]
    assert run(["animate", grid, "-o", "a.glb", *formats, "-q", "--life", "0"]) == 0
    keyed = load(take / "a.glb")
    assert run(["animate", grid, "-o", "b.glb", "-q", "--life", "0"]) == 0
    np.testing.assert_allclose(keyed.values, load(take / "b.glb").values, atol=0.02 + 1e-5)
