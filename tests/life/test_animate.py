"""Life in the whole path."""

import sys

import numpy as np
import pytest

from phonanim.face.contacts import CONTACTS
from phonanim.options import Options
from phonanim.pipeline import animate, animate_detailed
from phonanim.rig.neck import TURNS
from phonanim.speech.inventory import INVENTORY


@pytest.fixture(scope="module")
def line(line_without_sound):
    return line_without_sound


@pytest.fixture(scope="module")
def sound(root):
    return root / "examples" / "line.wav"


def test_it_is_on_unless_told_otherwise(line):
    alive, still = animate(line), animate(line, life=0)
    moved = {n for n, d in zip(alive.channels, np.ptp(alive.values - still.values, axis=0), strict=True) if d}
    assert {"eyeBlinkLeft", "eyeLookOutLeft", "browInnerUp", *TURNS} <= moved
    assert not any(name.startswith(("mouth", "tongue", "cheek")) for name in moved)
    assert not still.values[:, [still.channels.index(name) for name in TURNS]].any()


def test_the_mouth_is_that_of_the_speech(line, sound):
    alive, still = animate_detailed(line, Options(), sound), animate_detailed(line, Options(life=0), sound)
    bound = np.isin(alive.track.codes, INVENTORY.codes([p for c in CONTACTS for p in c.phones]))
    times = alive.animation.times
    held = alive.track.distance_to(bound, times) == 0
    mouth = [i for i, n in enumerate(alive.animation.channels) if n.startswith(("mouth", "jaw", "tongue"))]
    apart = np.abs(alive.animation.values - still.animation.values)[:, mouth]
    assert not apart[held].any()
    assert apart.max() <= 0.016


def test_a_line_gives_the_same_life_every_time_and_another_line_another(line, sound, tmp_path):
    again = [animate(line, audio=sound).values for _ in range(2)]
    np.testing.assert_array_equal(*again)
    (tmp_path / "other.TextGrid").write_bytes(line.read_bytes())
    other = animate(tmp_path / "other.TextGrid", audio=sound)
    assert np.abs(other.values - again[0]).max() > 0.3
    seeded = animate(tmp_path / "other.TextGrid", audio=sound, life_seed=3)
    np.testing.assert_array_equal(seeded.values, animate(line, audio=sound, life_seed=3).values)


def test_blinks_by_a_seed_of_their_own(line):
    plain, blinks = animate(line, life=0), animate(line, life=0, blinks=1)
    moved = {
        n for n, d in zip(plain.channels, np.ptp(blinks.values - plain.values, axis=0), strict=True) if d
    }
    assert {"eyeBlinkLeft", "eyeBlinkRight"} <= moved
    assert not any(name.startswith(("eyeLook", "head", "mouth", "jaw", "browInner")) for name in moved)


def test_pitch_moves_the_head(line, sound):
    with_sound, read = animate(line, audio=sound, loudness=0), animate(line)
    assert np.abs(with_sound.channel("headPitch") - read.channel("headPitch")).max() > 0.1
    np.testing.assert_array_equal(with_sound.channel("jawOpen"), read.channel("jawOpen"))


def test_a_recording_that_cannot_be_read_is_no_hindrance(line, tmp_path):
    broken = tmp_path / "line.wav"
    broken.write_bytes(b"RIFF")
    np.testing.assert_array_equal(animate(line, audio=broken).values, animate(line).values)


def test_praat_is_used_where_it_is_there(line, sound, monkeypatch):
    own = animate(line, audio=sound)
    monkeypatch.setitem(sys.modules, "parselmouth", None)
    without = animate(line, audio=sound, pitch="praat")
    np.testing.assert_array_equal(without.values, own.values)
    assert without.provenance["notes"] == [
        "pitch by Praat needs pip install 'phonanim[pitch]'; the built-in estimate is used"
    ]
    monkeypatch.undo()
    pytest.importorskip("parselmouth", reason="needs the extra pitch")
    other = animate(line, audio=sound, pitch="praat")
    assert not other.provenance["notes"]
    assert 0.01 < np.abs(other.channel("headPitch") - own.channel("headPitch")).max() < 2
    mouth = [i for i, name in enumerate(own.channels) if name.startswith("mouth")]
    assert np.abs(other.values - own.values)[:, mouth].max() < 0.02


def test_the_recording_beside_an_alignment_is_found(line, sound, root):
    found, given = animate(root / "examples" / "line.TextGrid"), animate(line, audio=sound)
    assert found.audio == sound
    np.testing.assert_array_equal(found.values, given.values)


def test_mouth_shapes_are_as_they_were(line):
    for rig in ("oculus15", "rhubarb", "vrm"):
        np.testing.assert_array_equal(animate(line, rig=rig).values, animate(line, rig=rig, life=0).values)
