import numpy as np
import pytest

from phonanim.life.chance import events, lognormal, normal, number_of, seed_of, uniform, wander


def test_a_number_is_the_same_whenever_it_is_asked_for():
    index = np.arange(-50, 1000)
    whole = uniform(3, "blink", index)
    np.testing.assert_array_equal(whole[70:90], uniform(3, "blink", index[70:90]))
    assert not np.array_equal(whole, uniform(4, "blink", index))
    assert not np.array_equal(whole, uniform(3, "gaze", index))


def test_distributions():
    index = np.arange(100_000)
    numbers = uniform(1, "a", index)
    assert (numbers > 0).all()
    assert (numbers < 1).all()
    np.testing.assert_allclose(np.histogram(numbers, 10, (0, 1))[0], 10_000, rtol=0.05)
    deviates = normal(1, "a", index)
    assert deviates.mean() == pytest.approx(0, abs=0.02)
    assert deviates.std() == pytest.approx(1, abs=0.02)
    assert lognormal(1, "a", index, 2.5, 0.6).mean() == pytest.approx(2.5, rel=0.02)


def gap(numbers):
    return 0.5 + lognormal(2, "gap", numbers, 1.5, 0.6)


def test_events_are_the_same_in_any_stretch_of_time():
    times, numbers = events(2, "x", gap, 0.5, 0.0, 600.0)
    part, own = events(2, "x", gap, 0.5, 100.0, 150.0)
    chosen = (times >= 100) & (times < 150)
    np.testing.assert_array_equal(part, times[chosen])
    np.testing.assert_array_equal(own, numbers[chosen])
    assert np.diff(times).min() >= 0.5
    assert np.diff(times).mean() == pytest.approx(2.0, rel=0.06)


def test_a_wandering_curve_is_smooth_and_the_same_in_any_stretch():
    times = np.arange(60_000) / 100
    curve = wander(5, "drift", times, 3.0)
    np.testing.assert_array_equal(curve[1000:1100], wander(5, "drift", times[1000:1100], 3.0))
    assert curve.std() == pytest.approx(1.0, abs=0.15)
    assert np.abs(np.diff(curve)).max() < 0.04


def test_seeds_of_lines_and_numbers_of_instants():
    assert seed_of("line_1") != seed_of("line_2")
    assert seed_of("line_1") == seed_of("line_1")
    assert number_of(np.array([1.2344, 1.2346])).tolist() == [1234, 1235]
