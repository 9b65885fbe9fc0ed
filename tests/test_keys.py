import numpy as np
import pytest
from animations import line, only
from hypothesis import given, settings
from hypothesis import strategies as st

from phonanim.keys import describe, describe_shared, hermite, reduce_channels, reduce_curve, reduce_curves


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-2, 2), min_size=1, max_size=40), st.floats(0, 0.5), st.booleans())
def test_no_frame_is_missed_by_more_than_the_tolerance(values, tolerance, straight):
    curve = np.array(values)
    keys = reduce_curve(curve, tolerance, straight)
    missed = np.abs(keys.sample(np.arange(len(curve), dtype=float))[:, 0] - curve).max()
    assert missed <= tolerance + 1e-9
    assert keys.error == pytest.approx(missed, abs=1e-9)
    assert set(np.diff(keys.frames) > 0) <= {True}


def test_a_cubic_needs_its_ends_alone():
    t = np.linspace(0, 1, 50)[:, None]
    curve = 3 * t**2 - 2 * t**3
    assert reduce_curves(curve, 0.005).frames.tolist() == [0, 49]


def test_a_still_curve_has_one_key():
    keys = reduce_curve(np.full(30, 0.3), 0.001)
    assert keys.frames.tolist() == [0]
    np.testing.assert_array_equal(keys.sample(np.array([0.0, 12.5, 29.0])), 0.3)


def test_zero_tolerance_keeps_the_curve():
    curve = np.random.default_rng(0).normal(size=20)
    np.testing.assert_allclose(reduce_curve(curve, 0.0).sample(np.arange(20.0))[:, 0], curve, atol=1e-12)


def test_needless_keys_are_taken_out():
    curve = np.sin(np.linspace(0, 12, 400))
    keys = reduce_curve(curve, 0.01)
    assert len(keys.frames) < 14
    slopes = keys.sample(np.arange(400) + 1e-4) - keys.sample(np.arange(400) - 1e-4)
    assert np.abs(np.diff(slopes[1:-1, 0])).max() < 1e-4  # no corners


def test_straight_spans_meet_at_their_keys():
    curve = np.concatenate([np.linspace(0, 1, 11), np.linspace(1, 0, 11)[1:]])
    keys = reduce_curve(curve, 1e-6, straight=True)
    assert keys.frames.tolist() == [0, 10, 20]
    assert keys.slopes is None
    np.testing.assert_allclose(keys.sample(np.array([2.5]))[0, 0], 0.25)


def test_a_closure_is_kept():
    curve = np.full(100, 0.4)
    curve[50:52] = 0.0
    assert reduce_curve(curve, 0.02).sample(np.array([50.0, 51.0])).max() <= 0.02


def test_the_span_meets_values_and_slopes_at_its_ends():
    ends = [np.array([[x]]) for x in (0.2, 0.5, 0.9, -0.25)]
    length = np.array([4.0])
    values = [float(hermite(np.array([x]), length, *ends)[0, 0]) for x in (0, 1e-6, 4 - 1e-6, 4)]
    assert values[0] == pytest.approx(0.2)
    assert values[3] == pytest.approx(0.9)
    assert (values[1] - values[0]) / 1e-6 == pytest.approx(0.5, abs=1e-4)
    assert (values[3] - values[2]) / 1e-6 == pytest.approx(-0.25, abs=1e-4)


def test_the_report_counts_moving_curves():
    animation = only(line(), jawOpen=0.5)
    values = animation.values.copy()
    values[:, animation.channels.index("mouthFunnel")] = np.linspace(0, 1, 61)
    moved = animation.with_values(values)
    text = describe(reduce_channels(moved, 0.01), moved)
    assert text == "2 keys in 1 moving curves, 2.0 per second each, largest error 0.0000"
    text = describe_shared(reduce_curves(moved.values, 0.01), moved)
    assert text == "2 keys that all curves share, 2.0 per second, largest error 0.0000"
