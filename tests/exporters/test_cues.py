import json
import re
from dataclasses import replace
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pytest
from animations import line

from phonanim.errors import OutputError
from phonanim.exporters import load, save
from phonanim.exporters._cues import SHORTEST, mouth_cues, phone_visemes
from phonanim.speech.alignment import Interval
from phonanim.speech.inventory import INVENTORY

SHAPES = set("ABCDEFGHX")
# "bob" with a burst too short to draw, and a closure as short that must stay.
BOB = (
    Interval("sil", 0.0, 0.2), Interval("B", 0.2, 0.3), Interval("AA", 0.3, 0.5), Interval("T", 0.5, 0.52),
    Interval("AA", 0.52, 0.6), Interval("B", 0.6, 0.62), Interval("UW", 0.62, 0.9), Interval("sil", 0.9, 1.0),
)  # fmt: skip


@pytest.fixture
def bob():
    return replace(line(), phones=BOB)


@pytest.mark.parametrize("table", ["rhubarb", "preston_blair"])
def test_every_phone_has_a_shape(table):
    assert set(phone_visemes(table)) == set(INVENTORY.phones)


def test_cues_lie_end_to_end_and_closures_stay(bob, tmp_path):
    cues = mouth_cues(bob, "rhubarb", tmp_path / "a.tsv")
    assert [cue.label for cue in cues] == ["X", "A", "D", "A", "F", "X"]
    assert [cue.start for cue in cues] == pytest.approx([0, 0.2, 0.3, 0.6, 0.62, 0.9])
    assert all(a.end == b.start for a, b in pairwise(cues))
    assert cues[-1].end == pytest.approx(1.0)
    assert all(cue.label == "A" or cue.end - cue.start >= SHORTEST for cue in cues)


def test_two_short_shapes_make_one(tmp_path):
    phones = (
        Interval("M", 0.0, 0.2),
        Interval("AA", 0.2, 0.22),
        Interval("S", 0.22, 0.25),
        Interval("M", 0.25, 0.5),
    )
    cues = mouth_cues(replace(line(), phones=phones), "rhubarb", tmp_path / "a.tsv")
    assert [(cue.label, cue.start, cue.end) for cue in cues[:3]] == [
        ("A", 0, 0.2),
        ("B", 0.2, 0.25),
        ("A", 0.25, 0.5),
    ]


def test_a_line_of_one_short_shape(tmp_path):
    brief = replace(line(frames=1), phones=(Interval("AA", 0.0, 0.02),))
    assert [cue.label for cue in mouth_cues(brief, "rhubarb", tmp_path / "a.tsv")] == ["D"]


def test_tsv(bob, tmp_path):
    save(bob, tmp_path / "a.tsv")
    rows = [row.split("\t") for row in (tmp_path / "a.tsv").read_text().splitlines()]
    assert rows[:3] == [["0.00", "X"], ["0.20", "A"], ["0.30", "D"]]
    assert rows[-1] == ["1.00", "X"]


def test_xml_and_json_agree(bob, tmp_path):
    bob = replace(bob, audio=tmp_path / "a & b.wav")
    for suffix in (".xml", ".rhubarb.json"):
        save(bob, tmp_path / f"a{suffix}")
    tree = ElementTree.fromstring((tmp_path / "a.xml").read_bytes())
    cues = json.loads((tmp_path / "a.rhubarb.json").read_text())
    assert tree.findtext("metadata/soundFile") == cues["metadata"]["soundFile"] == "a & b.wav"
    assert float(tree.findtext("metadata/duration")) == cues["metadata"]["duration"] == 1.0
    found = [
        (float(c.get("start")), float(c.get("end")), c.text) for c in tree.iterfind("mouthCues/mouthCue")
    ]
    assert found == [(c["start"], c["end"], c["value"]) for c in cues["mouthCues"]]


def test_moho_counts_frames_from_one(bob, tmp_path):
    save(bob, tmp_path / "a.dat")
    assert (
        tmp_path / "a.dat"
    ).read_text() == "MohoSwitch1\n1 rest\n6 MBP\n8 AI\n15 MBP\n16 U\n23 rest\n25 rest\n"
    save(bob, tmp_path / "a.dat", frame_rate=12)
    frames = [int(row.split()[0]) for row in (tmp_path / "a.dat").read_text().splitlines()[1:]]
    assert frames == sorted(set(frames))


def test_stepped_rigs_are_followed_frame_by_frame(bob, tmp_path):
    values = np.zeros((61, 3), np.float32)
    values[:20, 0] = values[20:40, 2] = values[40:, 1] = 1
    stepped = replace(bob, values=values, channels=("X", "A", "D"), rig="rhubarb")
    cues = mouth_cues(stepped, "rhubarb", tmp_path / "a.tsv")
    assert [(cue.label, round(cue.start * 60)) for cue in cues] == [("X", 0), ("D", 20), ("A", 40)]


def test_animations_without_phones(tmp_path):
    for suffix in (".tsv", ".xml", ".rhubarb.json", ".dat"):
        with pytest.raises(OutputError, match=r"a.* the animation has no phones, which are needed for"):
            save(replace(line(), phones=()), tmp_path / f"a{suffix}")


def test_tracks_keep_within_the_error_and_leave_out_what_is_still(tmp_path):
    animation = line()
    values = animation.values.copy()
    values[:, 3] = 0
    save(animation.with_values(values), tmp_path / "a.track.json", keys=0.05)
    tree = json.loads((tmp_path / "a.track.json").read_text())
    assert animation.channels[3] not in [channel["name"] for channel in tree["channels"]]
    assert sum(len(channel["keys"]) for channel in tree["channels"]) < values.size / 2
    again = load(tmp_path / "a.track.json")
    assert again.channels == animation.channels
    np.testing.assert_allclose(again.values, values, atol=0.05 + 1e-3)  # times have four digits


def test_tracks_that_are_none(tmp_path):
    path = tmp_path / "a.track.json"
    for text in ("{", "[]", '{"format": "x", "version": 1}', '{"format": "openfacefx.track", "version": 1}'):
        path.write_text(text)
        with pytest.raises(OutputError, match=r"a\.track\.json: is not an OpenFaceFX track of version 1: "):
            load(path)


def test_open_face_fx_reads_our_track(tmp_path):
    theirs = pytest.importorskip("openfacefx.io_export", reason="needs the package openfacefx")
    save(line(), tmp_path / "a.track.json")
    track = theirs.read_json(str(tmp_path / "a.track.json"))
    assert [channel.name for channel in track.channels] == list(line().channels)
    assert track.duration == pytest.approx(1.0, abs=1e-4)


def test_shapes_are_those_of_rhubarb(bob, tmp_path):
    save(bob, tmp_path / "a.tsv")
    assert set(re.findall(r"\t(\w)", (tmp_path / "a.tsv").read_text())) <= SHAPES
