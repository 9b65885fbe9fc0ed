import numpy as np
import pytest
from prosodies import sentences, track_of

from phonanim.life import AHEAD, BACK, BEHAVIOURS, Life, add_life, life_curves
from phonanim.rig import load_rig, rig_names
from phonanim.rig.neck import TURNS
from phonanim.speech.prosody import read_prosody

FPS = 60
SECONDS = 30.0
LINE = sentences(SECONDS - 8)
TIMES = np.arange(int(SECONDS * FPS) + 1) / FPS
PROSODY = read_prosody(track_of(LINE, SECONDS), ahead=AHEAD)


@pytest.mark.parametrize("ahead", [AHEAD, 0.2, 0.05])
def test_what_a_stream_knows_gives_what_the_whole_line_gives(ahead):
    whole = life_curves(Life(3), read_prosody(track_of(LINE, SECONDS), ahead=ahead), TIMES)
    done = 0
    for number in range(len(LINE) + 1):
        ended = number == len(LINE)
        known = SECONDS if ended else LINE[number].end
        due = len(TIMES) if ended else int((known - ahead) * FPS + 1e-6) + 1
        if due <= done:
            continue
        times = TIMES[done:due]
        felt = tuple(i for i in LINE[: number + 1] if i.end > times[0] - BACK)
        prosody = read_prosody(track_of(felt, known), ahead=ahead, ended=ended)
        for name, curve in life_curves(Life(3), prosody, times).items():
            np.testing.assert_allclose(curve, whole[name][done:due], atol=1e-9, err_msg=name)
        done = due
    assert done == len(TIMES)


def test_a_seed_gives_the_same_life_at_any_rate():
    slow, fast = (life_curves(Life(7), PROSODY, TIMES[::step]) for step in (2, 1))
    other = life_curves(Life(8), PROSODY, TIMES)
    for name, curve in fast.items():
        np.testing.assert_allclose(slow[name], curve[::2], atol=1e-12, err_msg=name)
    assert np.abs(other["headYaw"] - fast["headYaw"]).max() > 1


def test_it_fades_in_and_out():
    for name, curve in life_curves(Life(7), PROSODY, TIMES).items():
        assert curve[[0, -1]] == pytest.approx(0, abs=0.06), name


def test_curves_stay_within_sensible_limits():
    for name, curve in life_curves(Life(7), PROSODY, TIMES).items():
        if name in TURNS:
            assert np.abs(curve).max() < 9
            assert np.abs(np.diff(curve)).max() * FPS < 40  # degrees a second
        else:
            assert curve.min() >= 0
            assert curve.max() <= 1


@pytest.mark.parametrize(
    ("behaviour", "moved"),
    [
        ("blinks", {"eyeblink", "eyesquint", "browdown"}),
        ("gaze", {"eyelook", "eyewide", "eyeblink"}),
        ("head", {"head"}),
        ("brows", {"brow"}),
        ("breath", {"nosesneer", "jawopen", "chest", "headpitch"}),
    ],
)
def test_each_behaviour_moves_what_is_its_own(behaviour, moved):
    gains = dict.fromkeys(BEHAVIOURS, 0.0) | {behaviour: 1.0}
    curves = life_curves(Life(7, gains), PROSODY, TIMES)
    moving = {name.lower() for name, curve in curves.items() if np.ptp(curve) > 0}
    assert moving
    assert all(any(name.startswith(own) for own in moved) for name in moving)
    assert all(any(name.startswith(own) for name in moving) for own in moved)


def test_eyes_stay_on_the_listener_while_the_head_turns():
    gains = {"brows": 0.0, "blinks": 0.0}
    curves = life_curves(Life(7, gains), PROSODY, TIMES)
    still = life_curves(Life(7, gains), PROSODY, TIMES, turns_head=False)
    left = 25 * (curves["eyeLookOutLeft"] - curves["eyeLookInLeft"])
    fixed = 25 * (still["eyeLookOutLeft"] - still["eyeLookInLeft"])
    np.testing.assert_allclose(left + curves["headYaw"], fixed, atol=1e-9)


def test_looking_at_a_place():
    curves = life_curves(Life(7, {"head": 0.5}, look_at=(0.4, 0.0, 1.0)), PROSODY, TIMES)
    gaze = 25 * (curves["eyeLookOutLeft"] - curves["eyeLookInLeft"]) + curves["headYaw"]
    assert np.median(gaze) == pytest.approx(np.degrees(np.arctan2(0.4, 1.0)), abs=2.5)
    assert np.median(curves["headYaw"]) > 3


def test_rigs_of_mouth_shapes_are_as_they_were():
    for name in rig_names():
        rig = load_rig(name)
        rest = np.tile(rig.rest.astype(np.float32), (len(TIMES), 1))
        moved = add_life(rest, rig, Life(7), PROSODY, TIMES, np.ones(len(TIMES)))
        names = {name for name, curve in zip(rig.controls, moved.T, strict=True) if np.ptp(curve) > 0}
        if name in ("arkit", "arkit_tongue", "mediapipe", "metahuman"):
            assert len([name for name in names if "blink" in name.lower()]) == 2
            assert len([name for name in names if "brow" in name.lower()]) >= 4
        else:
            assert names == set(), name
        assert (moved >= rig.minimum.astype(np.float32)).all()
        assert (moved <= rig.maximum.astype(np.float32)).all()


def test_breath_leaves_the_mouth_alone_unless_it_is_free():
    rig = load_rig("arkit")
    rest = np.tile(rig.rest.astype(np.float32), (len(TIMES), 1))
    jaw = rig.controls.index("jawOpen")
    assert not add_life(rest, rig, Life(7), PROSODY, TIMES, np.zeros(len(TIMES)))[:, jaw].any()
    free = np.ones(len(TIMES))
    opened = add_life(rest, rig, Life(7), PROSODY, TIMES, free)[:, jaw]
    assert 0 < opened.max() < 0.03
    for start, end in zip(PROSODY.starts, PROSODY.ends, strict=True):
        assert not opened[slice(*np.searchsorted(TIMES, [start, end]))].any()


def test_a_rig_with_one_control_for_both_lids():
    from dataclasses import replace

    rig = load_rig("vrm")
    blinker = replace(rig, controls=("Blink", *rig.controls[1:]))
    moved = add_life(
        np.zeros((len(TIMES), 5), np.float32), blinker, Life(7), PROSODY, TIMES, np.ones(len(TIMES))
    )
    assert moved[:, 0].max() == 1.0
    assert not moved[:, 1:].any()
