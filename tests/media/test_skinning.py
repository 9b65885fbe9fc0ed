"""Skinned meshes lie where their joints put them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conventions import write_convention

from phonanim.media.glb import glb_bytes, read_glb
from phonanim.rig.character import load_character


def skinned(path: Path, moves: list[np.ndarray], joints: list[int]) -> Path:
    """A head whose points hang on two joints at the origin, bound by these matrices."""
    glb = read_glb(write_convention("BS_", path))
    tree, data = glb.tree, bytearray(glb.binary.ljust(len(glb.binary) + -len(glb.binary) % 4, b"\0"))
    node = next(n for n in tree["nodes"] if "mesh" in n)
    for primitive in tree["meshes"][node["mesh"]]["primitives"]:
        count = tree["accessors"][primitive["attributes"]["POSITION"]]["count"]
        own = np.zeros((count, 4), "<u2")
        own[:, 0] = np.resize(joints, count)
        full = np.tile(np.array([1, 0, 0, 0], "<f4"), (count, 1))
        primitive["attributes"] |= {
            "JOINTS_0": _added(tree, data, own, 5123, "VEC4"),
            "WEIGHTS_0": _added(tree, data, full, 5126, "VEC4"),
        }
    first = len(tree["nodes"])
    tree["nodes"] += [{"name": "a"}, {"name": "b"}]
    bound = np.array([move.T.ravel() for move in moves], "<f4")
    tree["skins"] = [
        {"joints": [first, first + 1], "inverseBindMatrices": _added(tree, data, bound, 5126, "MAT4")}
    ]
    node |= {"skin": 0, "translation": [5.0, 5.0, 5.0]}
    tree["buffers"] = [{"byteLength": len(data)}]
    path.write_bytes(glb_bytes(tree, bytes(data)))
    return path


def _added(tree, data: bytearray, values: np.ndarray, kind: int, shape: str) -> int:
    tree["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes})
    data += values.tobytes() + b"\0" * (-values.nbytes % 4)
    spec = {"bufferView": len(tree["bufferViews"]) - 1, "componentType": kind, "type": shape}
    tree["accessors"].append({**spec, "count": len(values)})
    return len(tree["accessors"]) - 1


@pytest.fixture
def plain(tmp_path):
    return load_character(write_convention("BS_", tmp_path / "plain.glb"))


def scaled(size: float, up: float = 0.0) -> np.ndarray:
    matrix = np.diag([size, size, size, 1.0])
    matrix[1, 3] = up
    return matrix


def test_joints_unpack_positions_and_the_node_places_nothing(tmp_path, plain):
    """Packed files hold integers, and the scale that makes metres of them in the joints."""
    head = load_character(skinned(tmp_path / "a.glb", [scaled(0.5, 1.0)] * 2, [0, 1]))
    np.testing.assert_allclose(head.vertices, plain.vertices * 0.5 + (0, 1, 0), atol=1e-6)
    np.testing.assert_allclose(head.deltas, plain.deltas * 0.5, atol=1e-6)


def test_each_point_follows_its_joint(tmp_path, plain):
    head = load_character(skinned(tmp_path / "b.glb", [np.eye(4), scaled(2.0)], [0, 1]))
    rows = slice(0, 40)  # points of the first part hang on one joint and the other by turns
    sizes = np.resize([1.0, 2.0], 40)[:, None]
    np.testing.assert_allclose(head.vertices[rows], plain.vertices[rows] * sizes, atol=1e-6)
    np.testing.assert_allclose(head.deltas[:, rows], plain.deltas[:, rows] * sizes, atol=1e-6)


def test_a_damaged_skin_places_nothing(tmp_path, plain):
    path = skinned(tmp_path / "c.glb", [scaled(0.5)] * 2, [0, 1])
    glb = read_glb(path)
    glb.tree["skins"][0]["inverseBindMatrices"] = 10_000
    path.write_bytes(glb_bytes(glb.tree, glb.binary))
    np.testing.assert_array_equal(load_character(path).vertices, plain.vertices)
