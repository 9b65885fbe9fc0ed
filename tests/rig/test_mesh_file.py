"""Meshes of every format: the vertices as the file has them, or one line that says what is wrong."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from phonanim.errors import MissingExtraError, RigError
from phonanim.rig.geometry import connected_labels, face_normals, uniform_laplacian, vertex_normals, weld
from phonanim.rig.mesh_file import read_mesh
from phonanim.rig.meshes import write_obj

CORNERS = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\n"
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def saved(folder: Path, text: str) -> Path:
    path = folder / "a.obj"
    path.write_text(text, encoding="utf-8")
    return path


def turned(triangles: list[list[int]]) -> set[tuple[int, ...]]:
    """Triangles that begin with their lowest corner, in any order."""
    return {tuple(np.roll(t, -int(np.argmin(t))).tolist()) for t in triangles}


@pytest.mark.parametrize(
    "face", ["f 1 2 3 4\n", "f -5 -4 -3 -2\n", "vt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3/1 4\n", "f 1 2 3\nf 1 3 4\n"]
)
def test_faces_of_an_obj_file(tmp_path: Path, face: str) -> None:
    points, triangles, _ = read_mesh(saved(tmp_path, CORNERS + face))
    assert points.tolist() == [*SQUARE.tolist(), [9, 9, 9]]
    assert turned(triangles.tolist()) == {(0, 1, 2), (0, 2, 3)}


def test_texture_seams_do_not_split_vertices(tmp_path: Path) -> None:
    seam = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/4 3/2 4/1\n"
    points, triangles, _ = read_mesh(saved(tmp_path, CORNERS + seam))
    assert len(points) == 5
    assert turned(triangles.tolist()) == {(0, 1, 2), (0, 2, 3)}


@pytest.mark.parametrize("word", ["o", "g"])
def test_parts_of_an_obj_file(tmp_path: Path, word: str) -> None:
    skin = f"{word} skin\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"
    eye = f"{word} eye_l\nv 2 0 0\nv 3 0 0\nv 3 1 0\nf 4 5 6\n"
    points, triangles, parts = read_mesh(saved(tmp_path, skin + eye))
    assert parts == {"skin": slice(0, 3), "eye_l": slice(3, 6)}
    assert triangles.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert len(points) == 6


def test_parts_that_share_vertices_are_one(tmp_path: Path) -> None:
    _, triangles, parts = read_mesh(saved(tmp_path, CORNERS + "g a\nf 1 2 3\ng b\nf 1 3 4\n"))
    assert parts == {"mesh": slice(0, 5)}
    assert turned(triangles.tolist()) == {(0, 1, 2), (0, 2, 3)}


def test_materials_do_not_split_a_mesh(tmp_path: Path) -> None:
    points, triangles, parts = read_mesh(saved(tmp_path, CORNERS + "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n"))
    assert (len(points), len(parts)) == (5, 1)
    assert turned(triangles.tolist()) == {(0, 1, 2), (0, 2, 3)}


def test_an_obj_file_comes_back(tmp_path: Path) -> None:
    write_obj(tmp_path / "b.obj", SQUARE, HALVES)
    points, triangles, _ = read_mesh(tmp_path / "b.obj")
    np.testing.assert_array_equal(points, SQUARE)
    np.testing.assert_array_equal(triangles, HALVES)


@pytest.mark.parametrize("kind", ["ply", "off", "stl"])
def test_other_formats(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"a.{kind}"
    trimesh.Trimesh(SQUARE, HALVES, process=False).export(path)
    points, triangles, parts = read_mesh(path)
    assert list(parts.values()) == [slice(0, 4)]
    assert {tuple(map(tuple, points[t].tolist())) for t in triangles} == {
        tuple(map(tuple, SQUARE[t].tolist())) for t in HALVES
    }
    if kind != "stl":  # which has no order
        np.testing.assert_array_equal(points, SQUARE)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 0 0 zero\nf 1 1 1\n", r"a.obj: is damaged or not an OBJ file \(.*\); export it again"),
        (
            "v 0 0 0\nf 1 2 3\n",
            r"a.obj: is damaged or not an OBJ file \(.*out of bounds.*\); export",
        ),
        ("v 0 0 0\nv 1 0 0\nf 1 2\n", "a.obj: holds no mesh; export the head with its faces"),
        ("v 0 0 0\n", "a.obj: holds no mesh; export the head with its faces"),
        ("", "a.obj: holds no mesh; export the head with its faces"),
        (
            "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
            "a.obj: holds positions that are not finite; export it again",
        ),
    ],
)
def test_damaged_files(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(RigError, match=message) as caught:
        read_mesh(saved(tmp_path, text))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", ["obj", "ply", "off", "stl"])
def test_random_damage_is_one_line(tmp_path: Path, kind: str) -> None:
    path, rng = tmp_path / f"a.{kind}", np.random.default_rng(5)
    trimesh.Trimesh(SQUARE, HALVES, process=False).export(path)
    whole = path.read_bytes()
    for _ in range(60):
        data = bytearray(whole[: rng.integers(1, len(whole))])
        data[rng.integers(len(data))] = rng.integers(256)
        path.write_bytes(bytes(data))
        try:
            read_mesh(path)
        except RigError as error:
            assert str(error).startswith(str(path))  # noqa: PT017
            assert "\n" not in str(error)  # noqa: PT017


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(RigError, match=r"gone.obj: cannot be read: No such file"):
        read_mesh(tmp_path / "gone.obj")


def test_trimesh_is_an_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(MissingExtraError, match=r"meshes needs trimesh: pip install 'phonanim\[rig\]'"):
        read_mesh(tmp_path / "a.obj")


def test_normals_by_hand() -> None:
    folded = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 1]], float)
    triangles = np.array([[0, 1, 2], [0, 3, 1], [0, 0, 1]])
    np.testing.assert_allclose(face_normals(folded, triangles), [[0, 0, 1], [0, 1, 0], [0, 0, 0]], atol=1e-15)
    ridge = np.array([0, 1, 2]) / np.sqrt(5)  # the larger triangle counts twice
    expected = [ridge, ridge, [0, 0, 1], [0, 1, 0]]
    np.testing.assert_allclose(vertex_normals(folded, triangles), expected, atol=1e-15)


def test_welding_and_connection() -> None:
    points = np.concatenate([SQUARE, SQUARE[[0, 2]] + 1e-8, [[5, 5, 5], [6, 5, 5], [5, 6, 5]]])
    triangles = np.array([[0, 1, 2], [4, 5, 3], [6, 7, 8]])
    kept, place = weld(points, triangles)
    assert kept.tolist() == [0, 1, 2, 3, 6, 7, 8]
    assert place.tolist() == [0, 1, 2, 3, 0, 2, 4, 5, 6]
    labels = connected_labels(place[triangles], len(kept))
    assert labels.tolist() == [labels[0]] * 4 + [labels[4]] * 3
    assert labels[0] != labels[4]


def test_the_laplacian_by_hand() -> None:
    edges = np.array([[0, 1], [1, 0], [1, 2]])
    expected = [[1, -1, 0, 0], [-0.5, 1, -0.5, 0], [0, -1, 1, 0], [0, 0, 0, 1]]
    np.testing.assert_array_equal(uniform_laplacian(edges, 4).toarray(), expected)
