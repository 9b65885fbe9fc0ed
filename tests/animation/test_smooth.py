"""Smoothing takes the quick out of the curves, moves nothing in time, and leaves closures closed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from speech import made_up_face, track_of

from phonanim.animation import smooth
from phonanim.animation.smooth import CLOSED, closure_mask, smooth_controls, width_for_cutoff
from phonanim.articulation import CHANNELS
from phonanim.face.contacts import lip_functionals
from phonanim.face.model import INNER_LIP_PAIRS
from phonanim.options import Options
from phonanim.pipeline import animate_detailed, load_model
from phonanim.rig import load_rig
from phonanim.rig.head import load_head
from phonanim.rig.landmark_rig import make_landmark_rig
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

PAIRS = len(INNER_LIP_PAIRS)
TOUCHING = 0.2  # mm


def wave(hertz, fps=240.0, seconds=4.0):
    return np.sin(2 * np.pi * hertz * np.arange(seconds * fps) / fps)[:, None].astype(np.float32)


def test_gaps_are_those_of_the_lips_alone():
    face = made_up_face(np.random.default_rng(0))
    gaps = smooth.lip_gaps(np.zeros((3, len(face.std))), face)
    assert gaps.shape == (3, PAIRS)
    upper, lower = (face.rows(side) for side in zip(*INNER_LIP_PAIRS, strict=True))
    np.testing.assert_allclose(gaps[0], face.mean[upper, 1] - face.mean[lower, 1])


def test_nothing_to_smooth_is_left_as_it_is():
    values = np.ones((5, 2), np.float32)
    assert smooth_controls(values, 0.0, 60) is values
    assert smooth_controls(values[:1], 0.1, 60) is not None
    np.testing.assert_allclose(smooth_controls(values, 0.2, 60), values, atol=1e-6)


@pytest.mark.parametrize("hertz", [3.0, 8.0])
def test_a_rate_in_hertz_halves_the_power_there_and_shifts_nothing(hertz):
    before = wave(hertz)
    middle = slice(240, 720)
    after = smooth_controls(before, width_for_cutoff(hertz), 240.0)[middle, 0]
    assert (after**2).mean() / (before[middle] ** 2).mean() == pytest.approx(0.5, abs=0.01)
    lags = [np.dot(after, np.roll(before[:, 0], lag)[middle]) for lag in range(-5, 6)]
    assert np.argmax(lags) == 5


def test_a_step_is_smoothed_alike_from_both_sides():
    step = np.repeat([[0.0], [1.0]], 60, axis=0).astype(np.float32)
    after = smooth_controls(step, 0.1, 60)[:, 0]
    np.testing.assert_allclose(after + after[::-1], 1.0, atol=1e-6)
    assert (np.diff(after) >= 0).all()


@given(st.integers(0, 1000), st.floats(0.0, 1.0), st.floats(24, 120))
def test_limits_that_were_kept_are_kept(seed, seconds, fps):
    rng = np.random.default_rng(seed)
    values = rng.uniform(0, 1, (40, 2)).astype(np.float32)
    values[:, 0] = np.minimum(values[:, 0], values[:, 1])
    firm = rng.choice([0.0, 0.5, 1.0], 40)
    after = smooth_controls(values, seconds, fps, firm)
    assert after.min() >= 0
    assert after.max() <= 1 + 1e-6
    assert (after[:, 0] <= after[:, 1] + 1e-6).all()
    np.testing.assert_array_equal(after[firm == 1], values[firm == 1])


def lip_gaps(values):
    face = load_model("default").face
    landmark_rig = make_landmark_rig(load_head(), shipped_landmarks(), face)
    upper, lower = (face.rows(side) for side in zip(*INNER_LIP_PAIRS, strict=True))
    posed = landmark_rig.pose(values[:, : len(landmark_rig.controls)])  # turns of the head come last
    return (posed[:, upper, 1] - posed[:, lower, 1]).max(axis=1)


def closed_lips(performance):
    return performance.animation.articulation[:, CHANNELS.index("lip_gap")] <= 0


def check_line(path, seconds):
    before = animate_detailed(path, Options(life=0, unknown="nearest"))
    after = animate_detailed(path, Options(life=0, unknown="nearest", smooth=seconds))
    values, times = before.animation.values, before.animation.times
    closed = closed_lips(before)
    np.testing.assert_array_equal(after.animation.values[closed], values[closed])
    assert lip_gaps(after.animation.values)[closed].max() == lip_gaps(values)[closed].max()
    lips = INVENTORY.codes(("p", "b", "m"))
    found = 0
    for code, begin, end in zip(
        before.track.codes, before.track.bounds[:-1], before.track.bounds[1:], strict=True
    ):
        inside = (times >= begin) & (times < end)
        if code in lips and inside.any():
            found += 1
            assert lip_gaps(values[inside]).min() <= TOUCHING
            assert lip_gaps(after.animation.values[inside]).min() <= TOUCHING
    jerks = [np.abs(np.diff(a.animation.values, 3, axis=0)).mean() for a in (after, before)]
    return found, jerks[0] / jerks[1]


@pytest.mark.parametrize("seconds", [0.05, 0.15, 1.0])
def test_closed_stays_closed_at_its_instants(root, seconds):
    found, jerk = check_line(root / "examples" / "line.TextGrid", seconds)
    assert found >= 4
    assert jerk < 0.8


def test_real_lines_stay_closed(shared_data):
    paths = sorted((shared_data / "textgrids").glob("00*_en_*.TextGrid"))
    counts = [check_line(path, 0.1)[0] for path in paths]
    assert sum(counts) > 10


def test_a_line_without_closures_is_smoothed_everywhere():
    face = load_model("default").face
    track = PhoneTrack(INVENTORY.codes(["aa"]), np.array([0.0, 1.0]), ("AA",))
    modes = np.zeros((10, len(face.std)))
    _, offset = lip_functionals(face)
    assert (offset[:PAIRS]).max() > CLOSED
    np.testing.assert_array_equal(closure_mask(modes, track, face, np.arange(10) / 60), 0)


def test_the_rig_behind_is_smoothed_too(root):
    rig = load_rig("metahuman")
    assert rig.through is not None
    quiet = animate_detailed(
        root / "examples" / "line.TextGrid", Options(life=0, rig="metahuman", smooth=0.1)
    ).animation.values
    line = root / "examples" / "line.TextGrid"
    loud = animate_detailed(line, Options(life=0, rig="metahuman")).animation.values
    assert np.abs(np.diff(quiet, axis=0)).mean() < np.abs(np.diff(loud, axis=0)).mean()


def test_the_core_of_a_closing_phone_is_left_alone_though_the_lips_are_open():
    pytest.importorskip("sklearn")  # the face is fitted with it
    face = made_up_face(np.random.default_rng(0))
    track = track_of("sil 0.4 aa 0.2 f 0.1 aa 0.2 sil 0.4")
    times = np.arange(0, track.duration, 0.005)
    opened = np.tile(face.std * [3, 0, 0], (len(times), 1))
    found = closure_mask(opened, track, face, times)
    assert (found[np.abs(times - 0.65) < 0.014] == 1).all()
    assert not found[np.abs(times - 0.65) > 0.08].any()
    without = track_of("sil 0.4 aa 0.5 sil 0.4")
    assert not closure_mask(opened, without, face, times).any()
