import numpy as np
import pytest

from phonanim.metrics import correlation, regression_slope, sd_ratio

CAPTURED = np.array([0.0, 3.0, 1.0, 4.0, 2.0])


def test_a_mouth_that_moves_half_as_far_has_half_the_ratio_and_slope_and_all_of_r():
    mumbled = 7.0 + CAPTURED / 2
    assert correlation(mumbled, CAPTURED) == pytest.approx(1.0)
    assert sd_ratio(mumbled, CAPTURED) == pytest.approx(0.5)
    assert regression_slope(mumbled, CAPTURED) == pytest.approx(0.5)


def test_the_slope_is_r_times_the_ratio():
    predicted = np.array([1.0, 2.0, 2.0, 3.0, 0.0])
    assert sd_ratio(predicted, CAPTURED) == pytest.approx(np.std(predicted) / np.std(CAPTURED))
    product = correlation(predicted, CAPTURED) * sd_ratio(predicted, CAPTURED)
    assert regression_slope(predicted, CAPTURED) == pytest.approx(product)


def test_a_capture_that_never_moves_has_neither():
    still = np.ones(5)
    assert np.isnan(sd_ratio(CAPTURED, still))
    assert np.isnan(regression_slope(CAPTURED, still))
    assert sd_ratio(still, CAPTURED) == 0
    assert regression_slope(still, CAPTURED) == 0
