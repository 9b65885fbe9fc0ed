import numpy as np
import pytest

from phonanim.metrics import temporal_misalignment
from phonanim.metrics.timing import find_peaks

TIMES = np.arange(120) / 30
CURVE = np.sin(9 * TIMES) + 0.3 * np.sin(23 * TIMES)


def test_a_curve_has_no_misalignment_with_itself_or_a_larger_copy():
    assert temporal_misalignment(CURVE, CURVE, 30) == 0
    assert temporal_misalignment(3 * CURVE + 2, CURVE, 30) == 0


@pytest.mark.parametrize("frames", [1, 3])
def test_a_delay_is_counted_in_seconds(frames):
    assert temporal_misalignment(np.roll(CURVE, frames), CURVE, 30) == pytest.approx(frames / 30, rel=0.2)


def test_what_has_no_extremum():
    assert np.isnan(temporal_misalignment(np.zeros(120), CURVE, 30))
    assert np.isnan(temporal_misalignment(CURVE, TIMES, 30))


def test_peaks_stand_out():
    curve = np.array([0.0, 1.0, 0.9, 1.2, 0.0, 0.3, 0.2, 2.0, 0.0])
    assert find_peaks(curve) == [3, 7]
    assert find_peaks(curve, 0.05) == [1, 3, 5, 7]
