"""Overlays leave what the lips say alone, stay within limits, and say what they cannot do."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from phonanim.animation.overlay import SHARE, find_overlay, hash_overlays, overlay_weight
from phonanim.core.lexicon import LEXICON
from phonanim.errors import OptionError
from phonanim.exporters import save
from phonanim.face.model import INNER_LIP_PAIRS
from phonanim.options import Options, Overlay
from phonanim.pipeline import animate, animate_detailed, load_model
from phonanim.rig import load_rig
from phonanim.rig.head import load_head
from phonanim.rig.landmark_rig import make_landmark_rig
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.speech.inventory import INVENTORY

GRIN = Overlay("smile", 1.5)
SILENT = ("sad", "angry", "surprised", "smile")


@pytest.fixture(scope="module")
def line(line_without_sound):
    return line_without_sound


@pytest.fixture(scope="module")
def plain(line):
    return animate_detailed(line, Options(life=0))


@pytest.fixture(scope="module")
def gaps():
    """Lip gaps of the shipped head at seven places, (frames, controls) -> (frames, 7) mm."""
    face = load_model("default").face
    landmark_rig = make_landmark_rig(load_head(), shipped_landmarks(), face)
    upper, lower = (face.rows(side) for side in zip(*INNER_LIP_PAIRS, strict=True))

    def of(animation):
        posed = landmark_rig.pose(
            animation.values[:, : len(landmark_rig.controls)]
        )  # turns of the head come last
        return posed[:, upper, 1] - posed[:, lower, 1]

    return of


def spoken(performance, *phones):
    """The frames in which one of these phones is said."""
    return np.isin(performance.track.sample(performance.animation.times), INVENTORY.codes(phones))


def pose(path, **values):
    path.write_text("".join(f"{name} = {value}\n" for name, value in values.items()))
    return str(path)


@pytest.mark.parametrize("name", SILENT)
def test_closures_are_those_of_the_speech_alone(line, plain, gaps, name):
    overlaid = animate(line, Options(life=0, overlays=(Overlay(name, 2.0),), blinks=1))
    held = spoken(plain, "p", "b", "m", "f", "v", "sh", "zh", "ch", "jh")
    assert held.sum() > 20
    np.testing.assert_allclose(gaps(overlaid)[held], gaps(plain.animation)[held], atol=1e-6)
    mouth = [n for n, control in enumerate(overlaid.channels) if control.startswith(("mouth", "jaw"))]
    np.testing.assert_array_equal(overlaid.values[held][:, mouth], plain.animation.values[held][:, mouth])
    assert np.abs(overlaid.values - plain.animation.values).max() > 0.3


def test_real_lines_keep_their_closures(shared_data, gaps):
    paths = sorted((shared_data / "textgrids").glob("00*_en_*.TextGrid"))
    assert paths
    for path in paths:
        before = animate_detailed(path, Options(life=0, unknown="nearest"))
        laid = Options(life=0, unknown="nearest", overlays=(GRIN, Overlay("angry")), blinks=5)
        after = animate_detailed(path, laid).animation
        closed = spoken(before, "p", "b", "m", "f", "v")
        assert np.abs(gaps(after)[closed] - gaps(before.animation)[closed]).max() < 1e-6


def test_brows_take_all_and_a_speaking_mouth_half(tmp_path, line, plain):
    source = pose(tmp_path / "up.toml", browInnerUp=0.5, mouthSmileLeft=0.25)
    added = animate(line, Options(life=0, overlays=(Overlay(source),))).values - plain.animation.values
    brow, smile = (plain.animation.channels.index(n) for n in ("browInnerUp", "mouthSmileLeft"))
    np.testing.assert_allclose(added[:, brow], 0.5, atol=1e-6)
    vowels = INVENTORY.where(kind="vowel")[plain.track.sample(plain.animation.times)]
    assert added[vowels, smile].max() == pytest.approx(SHARE * 0.25, abs=1e-6)
    assert added[0, smile] == pytest.approx(0.25, abs=0.02)  # before anything is said
    assert np.abs(np.diff(added[:, smile])).max() < 0.06  # at 60 frames per second: it never jumps


def test_freedom_is_nought_at_contacts_half_in_speech_whole_in_silence(plain):
    times = plain.animation.times
    free = overlay_weight(plain.track, times)
    assert free[spoken(plain, "p", "b", "m", "f", "v")].max() == 0
    assert free[~spoken(plain, "sil")].max() == SHARE
    assert free[0] > 0.9


def test_a_span_comes_and_goes(tmp_path, line, plain):
    source = pose(tmp_path / "up.toml", browInnerUp=0.5)
    brow = plain.animation.channels.index("browInnerUp")
    added = animate(line, Options(life=0, overlays=(Overlay(source, 0.5, (1.0, 2.0)),))).values[:, brow]
    times = plain.animation.times
    assert not added[(times < 1) | (times > 2)].any()
    np.testing.assert_allclose(added[(times > 1.25) & (times < 1.75)], 0.25, atol=1e-6)
    assert np.abs(np.diff(added)).max() < 0.03


@pytest.mark.parametrize("suffix", ["npz", "json", "glb", "csv", "track.json"])
def test_an_animation_of_any_format_that_is_read(tmp_path, plain, line, suffix):
    curves = np.zeros_like(plain.animation.values)
    brow = plain.animation.channels.index("browInnerUp")
    curves[:, brow] = np.sin(np.linspace(0, 3, len(curves)))
    save(plain.animation.with_values(curves), tmp_path / f"brow.{suffix}")
    overlay = Overlay(str(tmp_path / f"brow.{suffix}"), 0.5)
    added = animate(line, Options(life=0, fps=30, overlays=(overlay,))).values[:, brow]
    np.testing.assert_allclose(added[:130], 0.5 * curves[::2, brow][:130], atol=2e-3)


def test_a_real_capture_over_a_real_line(shared_data, line, plain, gaps):
    capture = shared_data / "formats" / "livelink_real_capture.csv"
    overlaid = animate(line, Options(life=0, overlays=(Overlay(str(capture)),)))
    closed = spoken(plain, "p", "b", "m")
    assert np.abs(gaps(overlaid)[closed] - gaps(plain.animation)[closed]).max() < 1e-6
    assert np.abs(overlaid.channel("eyeBlinkLeft")).max() > 0.5
    (note,) = overlaid.provenance["notes"]
    assert "left out what arkit has no control for: leftEyeYaw" in note


def test_limits_are_kept(line):
    rig = load_rig("arkit")
    values = animate(
        line, Options(life=0, jaw=2.0, overlays=(Overlay("surprised", 4.0), Overlay("smile", 4.0)))
    ).values
    assert (values >= rig.minimum).all()
    assert (values <= rig.maximum).all()
    for low, high in rig.at_most:
        assert (values[:, low] <= values[:, high]).all()


def test_the_rig_behind_takes_the_pose(line):
    plain = animate(line, Options(life=0, rig="metahuman"))
    smiling = animate(line, Options(life=0, rig="metahuman", overlays=(Overlay("smile"),)))
    moved = {
        n for n, d in zip(plain.channels, np.ptp(smiling.values - plain.values, axis=0), strict=True) if d
    }
    assert "CTRL_expressions_mouthCornerPullL" in moved
    assert not any("LipsTogether" in name for name in moved)


def test_drawn_mouths_take_nothing_and_say_so(line):
    options = Options(life=0, rig="rhubarb", overlays=(GRIN,), blinks=1, smooth=0.1, gains={"A": 0.5})
    drawn = animate(line, options)
    np.testing.assert_array_equal(drawn.values, animate(line, Options(life=0, rig="rhubarb")).values)
    (note,) = drawn.provenance["notes"]
    assert note.startswith(
        "rhubarb shows one mouth at a time, so gains, smooth, overlays, blinks, life did nothing"
    )


def test_shipped_poses_are_arkit_poses_within_limits(line):
    rig = load_rig("arkit")
    for path in (LEXICON / "poses").glob("*.toml"):
        (note,) = animate(
            line, Options(life=0, overlays=(Overlay(path.stem, 1.0, (90.0, 95.0)),))
        ).provenance["notes"]
        assert "shows nothing in a line of 4.52 s; give it another span or gain" in note
        assert rig.name == "arkit"


def test_the_contents_are_in_the_provenance(tmp_path, line):
    source = pose(tmp_path / "a.toml", browInnerUp=0.5)
    known = animate(line, Options(life=0, overlays=(Overlay(source, 0.5, (1.0, 2.0)),))).provenance
    assert known["options"]["overlays"] == [{"source": "a.toml", "gain": 0.5, "span": [1.0, 2.0]}]
    assert known["overlays_sha256"] == hash_overlays([Overlay(source)])
    pose(tmp_path / "a.toml", browInnerUp=0.6)
    assert known["overlays_sha256"] != hash_overlays([Overlay(source)])


BAD = {
    "a.toml": [
        ("mouthSmileLef = 0.5", "arkit has no control mouthSmileLef; did you mean mouthSmileLeft?"),
        ("xyzzy = 1", "arkit has no control xyzzy; write a pose of arkit's controls"),
        ("jawOpen = 1.2", "jawOpen = 1.2; give a number from 0 to 1"),
        ("jawOpen = nan", "jawOpen = nan; give a number from 0 to 1"),
        ("jawOpen = true", "jawOpen = True; give a number from 0 to 1"),
        ("jawOpen", "cannot be read: "),
    ],
    "a.json": [
        ('{"jawOpen": "wide"}', "jawOpen = 'wide'; give a number from 0 to 1"),
        ("[1]", "is not a pose; write CONTROL = VALUE, as mouthSmileLeft = 0.5"),
        ("{", "cannot be read: "),
    ],
}


@pytest.mark.parametrize(
    ("name", "text", "message"), [(n, *case) for n, cases in BAD.items() for case in cases]
)
def test_poses_that_make_no_sense(tmp_path, line, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(OptionError) as caught:
        animate(line, Options(life=0, overlays=(Overlay(str(tmp_path / name)),)))
    assert str(caught.value).startswith(f"overlay {tmp_path / name}: ")
    assert message in str(caught.value)


def test_an_animation_of_another_character(tmp_path, plain, line):
    strange = replace(plain.animation, channels=tuple(f"x{n}" for n in range(55)))
    (tmp_path / "a.json").write_text("")
    save(strange, tmp_path / "a.json")
    with pytest.raises(
        OptionError, match=r"none of its channels \(x0, x1, x2 \.\.\.\) is a control of arkit"
    ):
        animate(line, Options(life=0, overlays=(Overlay(str(tmp_path / "a.json")),)))


def test_names_that_are_not_there():
    assert find_overlay("smile") == LEXICON / "poses/smile.toml"
    with pytest.raises(
        OptionError, match=r"overlay smil: there is no such file or pose; did you mean smile\?"
    ):
        find_overlay("smil")
    with pytest.raises(OptionError, match=r"name a file, or one of angry, sad, smile, surprised"):
        find_overlay(str(Path("xyzzy.csv")))


def test_json_poses_are_poses_too(tmp_path, line, plain):
    (tmp_path / "a.json").write_text(json.dumps({"browInnerUp": 0.5}))
    options = Options(life=0, overlays=(Overlay(str(tmp_path / "a.json")),))
    added = animate(line, options).channel("browInnerUp")
    np.testing.assert_allclose(added, 0.5)


def test_an_overlay_that_takes_away_ends_at_the_least_value(line, tmp_path):
    """A pose below a control's least value is laid no lower."""
    rig = load_rig("arkit")
    plain = animate(line, Options())
    path = tmp_path / "below.csv"
    values = np.zeros_like(plain.values[:2])
    values[:, rig.controls.index("browInnerUp")] = -3.0
    save(plain.with_values(values), path)
    laid = animate(line, Options(overlays=(Overlay(str(path)),)))
    assert laid.values.min() >= rig.minimum.min()
    assert (laid.values >= rig.minimum).all()
