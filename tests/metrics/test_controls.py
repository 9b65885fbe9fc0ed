"""Measures of controls and of lips, each against its equation."""

from __future__ import annotations

import numpy as np
import pytest

from phonanim.errors import EvaluationError
from phonanim.evaluation.measures import mean_speed
from phonanim.metrics.arrays import absolute_error, summed_absolute_error
from phonanim.metrics.controls import control_diversity, control_dynamics_deviation

RNG = np.random.default_rng(3)
PREDICTED, CAPTURED = RNG.uniform(0, 1, (50, 67)), RNG.uniform(0, 1, (50, 67))


def test_the_l1_of_the_thesis_is_a_sum_over_67_parameters() -> None:
    """Tables 4.4 to 4.7 of Medina 2023: 67 times the mean."""
    summed = summed_absolute_error(PREDICTED, CAPTURED)
    wanted = [
        sum(abs(a - b) for a, b in zip(*rows, strict=True)) for rows in zip(PREDICTED, CAPTURED, strict=True)
    ]
    np.testing.assert_allclose(summed, wanted)
    np.testing.assert_allclose(summed, 67 * absolute_error(PREDICTED, CAPTURED))


def test_control_dynamics_by_their_equations() -> None:
    upper = np.array([2, 5, 11])

    def steps(curves: np.ndarray) -> float:
        return float(np.mean([np.std(np.abs(curves[1:, k] - curves[:-1, k])) for k in upper]))

    def energy(curves: np.ndarray) -> float:
        return float(np.std([sum(row[k] ** 2 for k in upper) for row in curves]))

    for motion, equation in (("step", steps), ("energy", energy)):
        found = control_dynamics_deviation(PREDICTED, CAPTURED, upper, motion)  # type: ignore[arg-type]
        assert found == pytest.approx(equation(CAPTURED) - equation(PREDICTED))
        assert control_dynamics_deviation(CAPTURED, CAPTURED, upper, motion) == 0  # type: ignore[arg-type]
    # A face that does not move has less of it than the captured one.
    assert control_dynamics_deviation(np.zeros_like(CAPTURED), CAPTURED, upper) > 0
    with pytest.raises(EvaluationError, match="there is no motion 'leap'; use step or energy"):
        control_dynamics_deviation(PREDICTED, CAPTURED, upper, "leap")  # type: ignore[arg-type]


def test_control_diversity_by_its_equation() -> None:
    takes = RNG.uniform(0, 1, (3, 20, 4))
    pairs = [(0, 1), (0, 2), (1, 2)]
    wanted = np.mean([np.mean(np.abs(takes[i] - takes[j])) for i, j in pairs])
    assert control_diversity(takes) == pytest.approx(wanted)
    assert control_diversity(takes[[0, 0]]) == 0
    with pytest.raises(EvaluationError, match="needs at least two takes of a line, not 1"):
        control_diversity(takes[:1])


def test_the_intensity_of_lips_is_their_mean_speed_in_speech() -> None:
    gap = np.array([0.0, 2, 2, 5, 5, 1])
    spoken = np.array([True, True, True, True, False, False])
    assert mean_speed(gap, spoken, 25.0) == pytest.approx(25 * (2 + 0 + 3) / 3)
    assert np.isnan(mean_speed(gap, np.zeros(6, bool), 25.0))
