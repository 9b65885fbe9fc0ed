import numpy as np
import pytest

from phonanim.animation.animation import Animation
from phonanim.exporters import load, save
from phonanim.media.glb import Glb, read_glb
from phonanim.rig.head import SHIPPED, load_head
from phonanim.rig.neck import TURNS, angles, find_bone, matrix, quaternions, turned, turns_of


def test_turns_are_down_to_the_left_and_to_the_right_shoulder():
    ahead, up = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    pitched, yawed, rolled = (matrix(turn) for turn in 20.0 * np.eye(3))
    assert (pitched @ ahead)[1] == pytest.approx(-np.sin(np.radians(20)))
    assert (yawed @ ahead)[0] == pytest.approx(np.sin(np.radians(20)))
    assert (rolled @ up)[0] == pytest.approx(-np.sin(np.radians(20)))


def test_angles_are_the_inverse_of_quaternions():
    turns = np.random.default_rng(0).uniform(-60, 60, (50, 3))
    np.testing.assert_allclose(angles(quaternions(turns)), turns, atol=1e-9)
    np.testing.assert_allclose(matrix(turns[0]).T @ matrix(turns[0]), np.eye(3), atol=1e-12)


def test_the_shipped_head_turns_and_its_shoulders_stay():
    head = load_head()
    moved = np.linalg.norm(
        turned(head.vertices, head.neck, np.array([0.0, 10.0, 0.0])) - head.vertices, axis=1
    )
    low = head.vertices[:, 1] < 0.56
    assert moved[low].max() < 1e-9
    for part in ("eye_l", "eye_r", "teeth_u", "teeth_l", "tongue"):
        assert head.neck.share[head.parts[part]].min() == 1.0
    assert 0.01 < moved[head.parts["eye_l"]].mean() < 0.03


def test_without_a_neck_or_a_turn_vertices_stay():
    head = load_head()
    assert turned(head.vertices, None, np.ones(3)) is head.vertices
    assert turned(head.vertices, head.neck, None) is head.vertices


def test_curves_of_turns():
    values = np.array([[0.5, 3.0, -2.0]])
    np.testing.assert_allclose(turns_of(values, ("jawOpen", "HeadYaw", "headPitch")), [[-2.0, 3.0, 0.0]])
    assert turns_of(0 * values, ("jawOpen", "headYaw", "headPitch")) is None
    assert turns_of(values, ("a", "b", "c")) is None


def character(**changes) -> Glb:
    """Nodes of a character whose head bone lies under a turned neck."""
    neck = {"name": "mixamorig:Neck", "rotation": [0.0, 0.6, 0.0, 0.8], "children": [1]}
    head = {"name": "mixamorig:Head", "rotation": [0.28, 0.0, 0.0, 0.96]}
    tree = {"nodes": [neck, head, {"name": "head"}], "skins": [{"joints": [0, 1]}], **changes}
    return Glb(tree, b"", "a.glb")


def test_the_bone_of_a_head():
    assert find_bone(character()).node == 1
    assert find_bone(character(skins=[])) is None
    human = {"VRMC_vrm": {"humanoid": {"humanBones": {"head": {"node": 0}}}}}
    assert find_bone(character(extensions=human)).node == 0
    older = {"VRM": {"humanoid": {"humanBones": [{"bone": "hips", "node": 0}, {"bone": "head", "node": 1}]}}}
    assert find_bone(character(extensions=older)).node == 1


def test_a_bone_turns_in_the_world_wherever_it_lies():
    bone = find_bone(character())
    turns = np.random.default_rng(1).uniform(-30, 30, (20, 3))
    rotations = bone.rotations(turns)
    np.testing.assert_allclose(np.linalg.norm(rotations, axis=1), 1, atol=1e-9)
    np.testing.assert_allclose(bone.turns(rotations), turns, atol=1e-9)
    np.testing.assert_allclose(bone.rotations(np.zeros((1, 3)))[0], bone.rest, atol=1e-9)
    backwards = find_bone(character(extensions={"VRM": {}}))
    assert not np.allclose(backwards.rotations(turns), rotations)


def test_a_glb_keeps_the_turn_of_the_head(tmp_path):
    turns = np.random.default_rng(2).uniform(-20, 20, (31, 3)).cumsum(axis=0) / 8
    channels = ("jawOpen", *TURNS)
    values = np.hstack([np.full((31, 1), 0.2), turns]).astype(np.float32)
    save(Animation(values, channels, 30.0, "arkit"), tmp_path / "a.glb")
    again = load(tmp_path / "a.glb")
    for name in TURNS:
        np.testing.assert_allclose(
            again.channel(name), values[:, channels.index(name)], atol=1e-4, err_msg=name
        )
    still = Animation(0 * values + 0.1 * (np.arange(4) == 0), channels, 30.0, "arkit")
    save(still, tmp_path / "b.glb")
    assert not set(TURNS) & set(load(tmp_path / "b.glb").channels)


def test_the_shipped_head_has_a_bone():
    bone = find_bone(read_glb(SHIPPED))
    np.testing.assert_allclose(bone.rest, [0, 0, 0, 1])
    np.testing.assert_allclose(load_head().neck.pivot, [0.0, 0.675, 0.03], atol=1e-6)
