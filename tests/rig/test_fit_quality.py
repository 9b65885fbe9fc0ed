"""A fit is judged by how far lips and jaw move, not by how alike they move; dead rigs are refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from phonanim.__main__ import run
from phonanim.errors import RigError
from phonanim.pipeline import load_model
from phonanim.rig import load_rig
from phonanim.rig.align import add_viseme_shapes
from phonanim.rig.fit_quality import FitQuality, check_alive, fit_quality
from phonanim.rig.head import Head, load_head
from phonanim.rig.landmarks import MeshLandmarks, shipped_landmarks, write_landmarks
from phonanim.rig.measuring import ARKIT, measure
from phonanim.rig.meshes import write_head


def shrunk(share: float) -> Head:
    """The shipped head, whose shapes move by a share of their way."""
    head = load_head()
    return replace(head, deltas=head.deltas * share)


def quality_of(head: Head) -> FitQuality:
    rig, face, spots = load_rig("arkit"), load_model("default").face, shipped_landmarks()
    return fit_quality(replace(rig, mouth=measure(head, spots, face, ARKIT)), head, spots, face)


def test_the_reference_follows_itself() -> None:
    found = quality_of(load_head())
    assert found.short == ()
    for followed in found.measures.values():
        assert followed.slope == pytest.approx(1.0, abs=0.01)
        assert followed.spread == pytest.approx(1.0, abs=0.01)
        assert followed.r > 0.99
    check_alive(found, "head.glb")


def test_shapes_that_move_too_little_are_said_with_numbers() -> None:
    found = quality_of(shrunk(0.12))
    assert found.measures["lip_gap"].r > 0.6
    assert any(line.startswith("jaw moves ") and "(90% wanted; " in line for line in found.short)


def test_a_mouth_that_hardly_moves_is_refused() -> None:
    with pytest.raises(RigError, match=r"hero.glb: its lips hardly follow speech \(r .* no rig is written"):
        check_alive(quality_of(shrunk(0.02)), "hero.glb")


def test_a_mouth_that_does_not_close_is_refused() -> None:
    found = replace(quality_of(load_head()), open_at_closures=4.0)
    with pytest.raises(
        RigError, match=r"hero.glb: its lips stay 4.0 mm apart at p b m, so no rig is written"
    ):
        check_alive(found, "hero.glb")


def test_a_dead_rig_leaves_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, spots = tmp_path / "hero.glb", tmp_path / "spots.csv"
    full = add_viseme_shapes(load_head())
    rows = [full.targets.index(name) for name in ("aa", "ih", "ou", "ee", "oh")]
    write_head(path, replace(full, targets=("aa", "ih", "ou", "ee", "oh"), deltas=full.deltas[rows] * 0.1))
    write_landmarks(spots, _known())
    assert run(["rig", "fit", str(path), "--landmarks", str(spots)]) == 2
    assert "so no rig is written" in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == [path, spots]


def _known() -> MeshLandmarks:
    return shipped_landmarks()


def test_a_head_whose_funnel_hardly_pushes_stands_out_by_its_pucker() -> None:
    rig, face = load_rig("arkit"), load_model("default").face
    head, spots = load_head(), shipped_landmarks()
    funnel = head.targets.index("mouthFunnel")
    deltas = head.deltas.copy()
    deltas[funnel, :, 2] *= 0.15
    other = replace(head, deltas=deltas)
    mouth = replace(rig, mouth=measure(other, spots, face, ARKIT))
    found = fit_quality(mouth, other, spots, face)
    assert found.reach["protrusion"] > 0.9
    assert found.measures["protrusion"].slope >= 0.8
    assert found.measures["lip_width"].slope >= 0.8
    assert found.measures["lip_gap"].slope >= 0.9


@pytest.mark.parametrize("name", ["vrm", "oculus15"])
def test_visemes_reach_what_is_asked_of_them(name: str) -> None:
    rig, face = load_rig(name), load_model("default").face
    head, spots = add_viseme_shapes(load_head()), shipped_landmarks()
    found = fit_quality(rig, head, spots, face)
    for measure_name, least in {"lip_gap": 0.9, "lip_width": 0.8, "protrusion": 0.8}.items():
        assert found.measures[measure_name].slope >= min(least, found.reach[measure_name])
