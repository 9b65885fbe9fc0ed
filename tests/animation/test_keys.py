import time
from dataclasses import replace

import numpy as np
import pytest
from animations import line, only
from hypothesis import given, settings
from hypothesis import strategies as st

from phonanim.animation.animation import Animation
from phonanim.animation.keys import (
    PART,
    _farthest,
    describe_keys,
    describe_shared_keys,
    reduce_channels,
    reduce_curve,
    reduce_curves,
)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-2, 2), min_size=1, max_size=40), st.floats(0, 0.5))
def test_no_frame_is_missed_by_more_than_the_tolerance(values, tolerance):
    curve = np.array(values)
    keys = reduce_curve(curve, tolerance)
    missed = np.abs(keys.sample(np.arange(len(curve), dtype=float))[:, 0] - curve).max()
    assert missed <= tolerance + 1e-9
    assert keys.error == pytest.approx(missed, abs=1e-9)
    assert set(np.diff(keys.frames) > 0) <= {True}


def test_a_straight_line_needs_its_ends_alone():
    assert reduce_curves(np.linspace([0, 1], [1, -3], 50), 1e-9).frames.tolist() == [0, 49]


def test_a_still_curve_has_one_key():
    keys = reduce_curve(np.full(30, 0.3), 0.001)
    assert keys.frames.tolist() == [0]
    np.testing.assert_array_equal(keys.sample(np.array([0.0, 12.5, 29.0])), 0.3)


def test_zero_tolerance_keeps_the_curve():
    curve = np.random.default_rng(0).normal(size=20)
    np.testing.assert_allclose(reduce_curve(curve, 0.0).sample(np.arange(20.0))[:, 0], curve, atol=1e-12)


def fewest(curve, tolerance):
    """The least number of keys, by trying every chain of spans (shortest path over frames)."""
    best = {0: 1}
    for last in range(1, len(curve)):
        spans = (
            first
            for first in range(last)
            if np.abs(
                np.linspace(curve[first], curve[last], last - first + 1) - curve[first : last + 1]
            ).max()
            <= tolerance
        )
        best[last] = 1 + min(best[first] for first in spans)
    return best[len(curve) - 1]


@pytest.mark.parametrize("tolerance", [0.003, 0.01, 0.05])
def test_there_are_hardly_more_keys_than_need_be(tolerance):
    times = np.linspace(0, 1, 120)
    curve = np.sin(9 * times) * np.exp(-times) + 0.1 * np.sin(40 * times)
    keys = reduce_curve(curve, tolerance)
    assert len(keys.frames) <= 1.1 * fewest(curve, tolerance) + 1


def test_curves_without_frames():
    with pytest.raises(ValueError, match="curves of no frames have no keys"):
        reduce_curves(np.zeros((0, 3)), 0.1)


def test_straight_spans_meet_at_their_keys():
    curve = np.concatenate([np.linspace(0, 1, 11), np.linspace(1, 0, 11)[1:]])
    keys = reduce_curve(curve, 1e-6)
    assert keys.frames.tolist() == [0, 10, 20]
    np.testing.assert_allclose(keys.sample(np.array([2.5]))[0, 0], 0.25)


def test_a_closure_is_kept():
    curve = np.full(100, 0.4)
    curve[50:52] = 0.0
    assert reduce_curve(curve, 0.02).sample(np.array([50.0, 51.0])).max() <= 0.02


def test_the_report_counts_moving_curves():
    animation = only(line(), jawOpen=0.5)
    values = animation.values.copy()
    values[:, animation.channels.index("mouthFunnel")] = np.linspace(0, 1, 61)
    moved = animation.with_values(values)
    text = describe_keys(reduce_channels(moved, 0.01), moved)
    assert text == "2 keys in 1 moving curves, 2.0 per second each, largest error 0.0000"
    slower = replace(moved, fps=30.5)
    assert ", 1.0 per second each" in describe_keys(reduce_channels(slower, 0.01), slower)
    keys = reduce_curves(moved.values, 0.01)
    assert ", 1.0 per second, " in describe_shared_keys(keys, slower)
    text = describe_shared_keys(keys, moved)
    assert text == "2 keys that all curves share, 2.0 per second, largest error 0.0000"


@given(st.integers(0, 10000), st.floats(0.0, 0.3))
def test_one_curve_has_the_keys_that_it_has_among_several(seed, tolerance):
    rng = np.random.default_rng(seed)
    curve = np.convolve(rng.normal(size=rng.integers(2, 200)), np.ones(5) / 5)[:, None]
    alone, among = reduce_curve(curve[:, 0], tolerance), reduce_curves(curve, tolerance)
    if len(alone.frames) > 1:
        np.testing.assert_array_equal(alone.frames, among.frames)
        assert alone.error == among.error <= tolerance + 1e-12


@pytest.mark.parametrize("curves", [1, 3])
def test_long_takes_have_the_keys_of_their_parts(curves: int) -> None:
    """A take of several parts is reduced side by side, as each part is by itself."""
    rng = np.random.default_rng(curves)
    dense = np.cumsum(rng.normal(size=(2 * PART + 100, curves)), axis=0) * 0.02
    found = reduce_curve(dense[:, 0], 0.05) if curves == 1 else reduce_curves(dense, 0.05)
    wanted = []
    for start in (0, PART, 2 * PART):
        part = dense[start : min(start + PART + 1, len(dense))]
        keys = [0]
        while keys[-1] < len(part) - 1:
            keys.append(_farthest(part, keys[-1], 0.05))
        wanted += [start + key for key in keys]
    np.testing.assert_array_equal(found.frames, np.unique(wanted))
    assert found.error <= 0.05


def test_channels_of_a_long_take_are_reduced_each_by_itself() -> None:
    values = np.zeros((PART + 50, 3), np.float32)
    values[:, 1] = np.sin(np.arange(len(values)) / 9)
    values[:, 2] = np.random.default_rng(0).normal(size=len(values))
    animation = Animation(values, ("still", "wave", "noise"), 60.0, "arkit")
    found = reduce_channels(animation, 0.01)
    for column, name in enumerate(animation.channels):
        alone = reduce_curve(values[:, column], 0.01)
        np.testing.assert_array_equal(found[name].frames, alone.frames)
        np.testing.assert_array_equal(found[name].values, alone.values)
        assert found[name].error == alone.error <= 0.01


@pytest.mark.parametrize("frames", [PART, 40 * PART])
def test_a_zigzag_as_high_as_the_error_takes_no_longer(frames: int) -> None:
    """Its cone of slopes never closes, and no frame is ever within it."""
    curve = np.tile([0.01, -0.01], frames // 2)
    curve[0], curve[-1] = 0.0, 1.0
    started = time.process_time()
    found = reduce_curve(curve, 0.01)
    assert found.error <= 0.01
    assert time.process_time() - started < 5
