"""Heat maps add up the errors of each vertex and curve."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from animations import speaking

from phonanim.__main__ import run
from phonanim.animation.animation import Animation
from phonanim.errors import EvaluationError
from phonanim.evaluation.heat import PREDICTIONS, Heat, add_matched
from phonanim.evaluation.motion_map import SIDES, MotionMap
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


def test_sides_are_matched_first() -> None:
    """At common instants and controls; what cannot be matched is said."""
    heat, times = Heat(), np.arange(10)
    still = Animation(np.zeros((10, 2), np.float32), ("jawOpen", "own"), 10.0, "mine")
    moved = Animation(times[:, None].astype(np.float32) / 5, ("jawOpen",), 5.0, "mine")
    add_matched(heat, still, moved)
    assert heat.names == ("jawOpen",)
    assert heat.means()[PREDICTIONS] == pytest.approx([np.mean(np.arange(heat.frames[PREDICTIONS]) / 5)])
    mesh = Vertices(np.zeros((10, 4, 3)), 10.0)
    with pytest.raises(EvaluationError, match="curves on both sides, or vertices on both"):
        add_matched(heat, still, mesh)
    with pytest.raises(EvaluationError, match="needs one mesh: 4 and 3 vertices"):
        add_matched(heat, mesh, Vertices(np.zeros((10, 3, 3)), 10.0))


def test_evaluate_draws_a_mesh(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    rng = np.random.default_rng(2)
    rest = rng.normal(0, 0.05, (30, 3))
    for side, size in (("ours", 0.001), ("theirs", 0.002)):
        (tmp_path / side).mkdir()
        for line in ("a", "b"):
            points = rest + size * np.sin(np.arange(12))[:, None, None]
            np.save(tmp_path / side / f"{line}.npy", points.astype(np.float32))
    given = ["evaluate", str(tmp_path / "ours"), "--reference", str(tmp_path / "theirs"), "--unit", "m"]
    assert run([*given, "--heat", str(tmp_path / "heat.png"), "--fps", "30"]) == 0
    assert "mve_mm" in capsys.readouterr().out
    assert (tmp_path / "heat.png").read_bytes().startswith(b"\x89PNG")
    assert run([*given, "--heat", str(tmp_path / "no/heat.png")]) == 2
    assert "no/heat.png" in capsys.readouterr().err


def test_motion_is_speed_whatever_the_rate() -> None:
    found, times = MotionMap(), np.arange(21) / 20
    steady = np.zeros((21, 2, 3))
    steady[:, 1, 0] = 4 * times
    found.add(Vertices(steady, 20.0), Vertices(steady[::2], 10.0))
    jumps = steady.copy()
    jumps[:, 1, 0] = 4 * (np.arange(21) // 2) / 10
    found.add(Vertices(jumps, 20.0), Vertices(steady[::2], 10.0))
    measures = found.measures()
    for side in SIDES:
        assert measures["mean"][side] == pytest.approx([0, 4])
    assert measures["sd"][SIDES[0]] == pytest.approx(
        [0, np.sqrt(8)]
    )  # half of the steps are 8 and 0 in turns
    assert measures["sd"][SIDES[1]] == pytest.approx([0, 0], abs=1e-6)
    with pytest.raises(EvaluationError, match="needs one mesh: 2 and 3 vertices"):
        found.add(Vertices(np.zeros((9, 3, 3)), 20.0), Vertices(steady, 20.0))
    with pytest.raises(EvaluationError, match="motion map needs curves on both sides, or vertices on both"):
        found.add(Animation(np.zeros((9, 1), np.float32), ("jaw",), 20.0, "mine"), Vertices(steady, 20.0))


def test_motion_maps_of_meshes_and_of_curves(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    rest = np.random.default_rng(2).normal(0, 0.05, (30, 3))
    for name, size in (("ours", 0.001), ("theirs", 0.002)):
        points = rest + size * np.sin(np.arange(12))[:, None, None] * np.arange(30)[:, None]
        np.save(tmp_path / f"{name}.npy", points.astype(np.float32))
        speaking().save(tmp_path / f"{name}.npz")
    for suffix in ("npy", "npz"):
        given = [
            "evaluate",
            str(tmp_path / f"ours.{suffix}"),
            "--reference",
            str(tmp_path / f"theirs.{suffix}"),
        ]
        assert run([*given, "--motion-map", str(tmp_path / f"{suffix}.png")]) == 0
        assert (tmp_path / f"{suffix}.png").read_bytes().startswith(b"\x89PNG")
