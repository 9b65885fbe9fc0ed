"""Deformation transfer: onto the head itself it is the identity; onto others, lips that close stay closed."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.errors import RigError
from phonanim.face.model import INNER_LIP_PAIRS
from phonanim.rig.character import load_character
from phonanim.rig.geometry import face_normals
from phonanim.rig.head import TONGUE, Head, load_head
from phonanim.rig.interior_parts import outer_rows
from phonanim.rig.landmarks import MeshLandmarks, shipped_landmarks
from phonanim.rig.mesh_file import load_mesh
from phonanim.rig.meshes import write_obj
from phonanim.rig.transfer import Report, transfer
from phonanim.rig.unflip import unflip


def bare(head: Head) -> Head:
    return replace(head, targets=(), deltas=np.zeros((0, *head.vertices.shape)))


def longer(head: Head) -> Head:
    """Another face: longer below the eyes, broader, in centimetres, its vertices in another order."""
    eyes = head.vertices[head.parts["eye_l"], 1].mean()
    grown = head.vertices * (1.06, 1.0, 1.03)
    grown[:, 1] += 0.12 * np.minimum(head.vertices[:, 1] - eyes, 0)
    return replace(bare(head), vertices=grown * 100)


@cache
def onto_itself() -> tuple[Head, MeshLandmarks, Report]:
    return transfer(load_head(), shipped_landmarks(), bare(load_head()))


@cache
def onto_another() -> tuple[Head, MeshLandmarks, Report]:
    return transfer(load_head(), shipped_landmarks(), longer(load_head()))


def mouth_shapes() -> list[int]:
    return [i for i, name in enumerate(load_head().targets) if name.startswith(("jaw", "mouth"))]


def test_onto_the_same_head_the_shapes_come_back() -> None:
    head, (made, _, report) = load_head(), onto_itself()
    skin = head.parts["skin"]
    errors = []
    for number in mouth_shapes():
        motion = np.linalg.norm(head.deltas[number][skin], axis=1)
        apart = np.linalg.norm(made.deltas[number][skin] - head.deltas[number][skin], axis=1)
        moved = motion > 0.1 * motion.max()
        errors.append(apart[moved].mean() / motion[moved].mean())
    assert made.targets == head.without(TONGUE).targets
    assert np.median(errors) < 0.02
    assert report.matched > 0.99


def test_teeth_and_eyes_follow_their_own() -> None:
    head, (made, _, report) = load_head(), onto_itself()
    assert {part: report.carried[part] for part in ("teeth_u", "teeth_l", "eye_l")} == {
        part: part for part in ("teeth_u", "teeth_l", "eye_l")
    }
    jaw = head.targets.index("jawOpen")
    lower = head.parts["teeth_l"]
    np.testing.assert_allclose(made.deltas[jaw][lower], head.deltas[jaw][lower], atol=1e-3)
    assert np.abs(made.deltas[jaw][head.parts["teeth_u"]]).max() < 1e-4


def test_another_face_moves_alike_and_closes_its_lips() -> None:
    head, (made, spots, _) = load_head(), onto_another()
    names = made.targets
    opened = spots.of(made.vertices + made.deltas[names.index("jawOpen")])
    closed = spots.of(
        made.vertices + made.deltas[names.index("jawOpen")] + made.deltas[names.index("mouthClose")]
    )
    middle = slice(1, -1)
    gaps = {
        name: np.array([points[a, 1] - points[b, 1] for a, b in INNER_LIP_PAIRS])[middle] * 10
        for name, points in (("rest", spots.of(made.vertices)), ("opened", opened), ("closed", closed))
    }
    own = shipped_landmarks().of(head.vertices + head.deltas[names.index("jawOpen")]) * 1000
    assert gaps["opened"].max() == pytest.approx(own[13, 1] - own[14, 1], rel=0.25)  # mm
    assert np.abs(gaps["closed"]).max() < 2.0
    assert np.abs(gaps["rest"]).max() < 2.0


def test_shapes_are_in_the_new_heads_own_units_and_leave_its_rest_alone() -> None:
    head, (made, _, _) = load_head(), onto_another()
    np.testing.assert_array_equal(made.vertices, longer(head).vertices)
    jaw = head.targets.index("jawOpen")
    assert np.abs(made.deltas[jaw]).max() == pytest.approx(100 * np.abs(head.deltas[jaw]).max(), rel=0.3)
    still = head.vertices[:, 1] > 0.8  # the crown
    assert np.abs(made.deltas[mouth_shapes()][:, still]).max() < 0.03  # cm


def test_no_triangle_is_turned_over() -> None:
    made, _, report = onto_another()
    assert report.flipped == 0
    assert report.straightened > 0
    for delta in made.deltas:
        facing = [face_normals(points, made.triangles) for points in (made.vertices, made.vertices + delta)]
        assert (facing[0] * facing[1]).sum(axis=1).min() > -1e-9


def test_a_lining_that_is_joined_to_the_skin_deforms_with_it() -> None:
    head = longer(load_head())
    inner = np.arange(4000, head.parts["skin"].stop)
    parts = {"face": slice(0, 4000), "mouth_socket": slice(4000, head.parts["skin"].stop)}
    apart = replace(head, parts={**parts, **{k: v for k, v in head.parts.items() if k != "skin"}})
    assert np.isin(inner, outer_rows(apart)).all()
    assert not np.isin(head.parts["tongue"].start, outer_rows(apart))


def test_a_shape_that_turns_triangles_over_is_straightened_where_it_does() -> None:
    across, along = np.meshgrid(np.arange(30.0), np.arange(30.0))
    points = np.column_stack([across.ravel(), along.ravel(), np.zeros(900)]) / 1000
    first = (np.arange(29)[:, None] * 30 + np.arange(29)).ravel()
    triangles = np.concatenate(
        [np.column_stack([first, first + 1, first + 31]), np.column_stack([first, first + 31, first + 30])]
    )
    delta = np.zeros_like(points)
    delta[15 * 30 + 15] = (0.0025, 0.0, 0.0)  # over its neighbours
    before = face_normals(points + delta, triangles)[:, 2]
    straight, remain = unflip(points, delta, triangles)
    assert (before < 0).any()
    assert remain == 0
    assert (face_normals(points + straight, triangles)[:, 2] > 0).all()
    far = np.linalg.norm(points - points[15 * 30 + 15], axis=1) > 0.008
    np.testing.assert_allclose(straight[far], delta[far], atol=1e-5)


def test_what_turns_nothing_over_stays_as_it_was() -> None:
    head = load_head()
    delta = head.deltas[head.targets.index("mouthPucker")] / 10
    straight, remain = unflip(head.vertices, delta, head.triangles)
    assert remain == 0
    assert straight is delta


def test_split_vertices_do_not_tear() -> None:
    head = load_head()
    split = head.triangles[: len(head.triangles) // 2]
    vertices = np.concatenate([head.vertices, head.vertices[split].reshape(-1, 3)])
    triangles = np.concatenate(
        [len(head.vertices) + np.arange(split.size).reshape(-1, 3), head.triangles[len(split) :]]
    )
    flat = Head(
        vertices,
        triangles,
        {"skin": slice(0, len(vertices))},
        (),
        np.zeros((0, *vertices.shape)),
        np.ones_like(vertices),
    )
    made, _, _ = transfer(head, shipped_landmarks(), flat)
    jaw = made.deltas[head.targets.index("jawOpen")]
    mouth = np.argmax(
        np.abs(head.deltas[head.targets.index("jawOpen")]).sum(axis=1)
        * np.isin(np.arange(len(head.vertices)), split)
    )
    copies = len(head.vertices) + np.flatnonzero(split.ravel() == mouth)
    assert len(copies) > 1
    assert np.abs(jaw[copies[0]]).max() > 0.01
    np.testing.assert_allclose(jaw[copies], np.tile(jaw[copies[0]], (len(copies), 1)), atol=1e-9)


def test_what_is_no_head_is_said() -> None:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(300, 3)) * (1.0, 0.05, 1.0)
    triangles = rng.integers(0, 300, (500, 3))
    plank = Head(points, triangles, {"mesh": slice(0, 300)}, (), np.zeros((0, 300, 3)), np.ones((300, 3)))
    with pytest.raises(RigError, match="does not look like a head that faces forward, y up"):
        transfer(load_head(), shipped_landmarks(), plank)


def test_a_file_without_meshes_is_said(tmp_path: Path) -> None:
    from phonanim.media.glb import glb_bytes

    path = tmp_path / "empty.glb"
    path.write_bytes(glb_bytes({"asset": {"version": "2.0"}, "nodes": [{"name": "nothing"}]}, b""))
    with pytest.raises(RigError, match="holds no mesh; export the head"):
        load_mesh(path)


def test_a_glb_without_shapes_can_be_a_target() -> None:
    from phonanim.rig.head import SHIPPED

    mesh = load_mesh(SHIPPED)
    assert mesh.targets == ()
    head = load_head().vertices
    np.testing.assert_allclose(mesh.vertices[: len(head)], head, atol=1e-6)  # then the hair


@pytest.mark.slow
def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    head = longer(load_head())
    mesh, made = tmp_path / "hero.obj", tmp_path / "hero.glb"
    write_obj(mesh, head.vertices, head.triangles)
    assert run(["rig", "transfer", "--from", "shipped", "--to", str(mesh), "-o", str(made), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["matched"] > 0.7
    character = load_character(made)
    assert character.targets == load_head().without((*TONGUE, "tongueOut")).targets  # no tongue
    table = ["--landmarks", facts["landmarks"], "--json"]
    assert run(["rig", "fit", str(made), *table]) == 0
    assert json.loads(capsys.readouterr().out)["measures"]["lip_gap"]["slope"] > 0.9
