"""Heat maps add up the errors of each vertex and curve."""

from __future__ import annotations

import numpy as np
import pytest

from phonanim.animation.animation import Animation
from phonanim.evaluation.heat import Heat
from phonanim.evaluation.predictions import Vertices


def test_vertices_by_distance_over_all_clips() -> None:
    heat, rest = Heat(), np.zeros((4, 3, 3))
    moved = rest + np.array([[0, 0, 0], [3, 4, 0], [0, 0, 1]])
    heat.add({"a": Vertices(moved, 30.0)}, Vertices(rest, 30.0))
    heat.add({"a": Vertices(rest[:2], 30.0)}, Vertices(rest[:2], 30.0))
    assert heat.means()["a"] == pytest.approx(np.array([0, 5, 1]) * 4 / 6)
    assert heat.places is not None
    assert heat.places.shape == (3, 2)


def test_curves_by_size() -> None:
    heat, values = Heat(), np.array([[0, 1], [1, 1]], np.float32)
    take = Animation(values, ("jaw", "lips"), 30.0, "mine")
    heat.add({"a": take.with_values(values + np.array([0.5, -0.25], np.float32)), "b": take}, take)
    assert heat.means()["a"] == pytest.approx([0.5, 0.25])
    assert heat.means()["b"] == pytest.approx([0, 0])
    assert heat.names == ("jaw", "lips")
    assert heat.spread == pytest.approx([0.5, 0])
