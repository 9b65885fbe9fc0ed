import numpy as np
import pytest

from phonanim.animation.blinks import RATE, blink_curve, eyelid_controls
from phonanim.options import Options
from phonanim.pipeline import animate
from phonanim.rig import load_rig


def starts(seed, seconds, fps=120):
    closed = blink_curve(seed, np.arange(seconds * fps) / fps)
    return np.flatnonzero((closed[:-1] == 0) & (closed[1:] > 0)) / fps


def test_people_who_talk_blink_as_often():
    rates = [len(starts(seed, 120)) / 120 for seed in range(30)]
    assert np.mean(rates) == pytest.approx(RATE, rel=0.05)
    pauses = np.concatenate([np.diff(starts(seed, 120)) for seed in range(10)])
    assert pauses.min() > 0.5
    assert np.mean(pauses) > 1.1 * np.median(pauses)  # a long tail, as of a log-normal


def test_eyes_close_fully_and_faster_than_they_open():
    times = np.arange(60 * 120) / 120
    closed = blink_curve(0, times)
    assert closed.max() == 1.0
    assert closed.min() == 0.0
    speed = np.diff(closed)
    assert speed.max() > -1.5 * speed.min() > 0


def test_a_seed_gives_the_same_blinks_at_any_rate():
    np.testing.assert_array_equal(blink_curve(3, np.arange(601) / 60), blink_curve(3, np.arange(601) / 60))
    slow, fast = blink_curve(3, np.arange(251) / 25), blink_curve(3, np.arange(1001) / 100)
    np.testing.assert_allclose(slow, fast[::4], atol=1e-12)
    assert np.abs(blink_curve(4, np.arange(601) / 60) - blink_curve(3, np.arange(601) / 60)).max() == 1


@pytest.mark.parametrize(("name", "count"), [("arkit", 2), ("metahuman", 2), ("mediapipe", 2), ("vrm", 0)])
def test_the_lids_of_rigs(name, count):
    assert len(eyelid_controls(load_rig(name).controls)) == count


def test_a_line_blinks_and_says_nothing_else(root):
    path = root / "examples" / "line.TextGrid"
    plain, blinks = animate(path), animate(path, Options(blinks=1))
    moved = {
        n for n, d in zip(plain.channels, np.ptp(blinks.values - plain.values, axis=0), strict=True) if d
    }
    assert moved == {"eyeBlinkLeft", "eyeBlinkRight"}
    (note,) = animate(path, Options(rig="vrm", blinks=1)).provenance["notes"]
    assert note == "vrm has no control that blinks, so it does not"
