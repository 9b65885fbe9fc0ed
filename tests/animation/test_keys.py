from dataclasses import replace

import numpy as np
import pytest
from animations import line, only
from hypothesis import given, settings
from hypothesis import strategies as st

from phonanim.animation.keys import (
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
