"""The animation in a character of the user's own: several meshes, a skeleton, expressions, compression."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from animations import line, only

from phonanim.errors import OutputError, RigError
from phonanim.exporters import load, save
from phonanim.media.glb import Glb, glb_bytes, read_glb


def character(names=("browUp", "JawOpen"), teeth=("Teeth.jaw_open",)):
    """A face, teeth and a body on two bones, with an animation of its own."""
    binary = np.zeros(16, "<f4").tobytes()
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 8},
    ]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0] * 3, "max": [0] * 3},
        {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [0]},
    ]

    def mesh(name, targets):
        primitive = {"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0} for _ in targets]}
        return {"name": name, "primitives": [primitive], "extras": {"targetNames": list(targets)}}

    spin = {
        "channels": [{"sampler": 0, "target": {"node": 4, "path": "scale"}}],
        "samplers": [{"input": 1, "output": 0}],
    }
    tree = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0, 1, 2, 3]}],
        "nodes": [{"mesh": 0}, {"mesh": 1}, {"mesh": 2, "skin": 0}, {"children": [4]}, {}],
        "meshes": [
            mesh("head", names),
            mesh("head", teeth),
            {"primitives": [{"attributes": {"POSITION": 0}}]},
        ],
        "skins": [{"joints": [3, 4]}],
        "materials": [{"name": "skin"}],
        "animations": [spin],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    return Glb(tree, binary, "mine.glb")


@pytest.fixture
def mine(tmp_path):
    def write(glb=None):
        glb = glb or character()
        path = tmp_path / "mine.glb"
        path.write_bytes(glb_bytes(glb.tree, glb.binary))
        return path

    return write


def test_face_and_teeth_move_and_the_rest_stays(tmp_path, mine):
    save(line(), tmp_path / "a.glb", character=mine())
    before, after = character(), read_glb(tmp_path / "a.glb")
    assert after.binary.startswith(before.binary)
    for key in ("nodes", "meshes", "skins", "materials", "scenes"):
        assert after.tree[key] == before.tree[key]
    assert after.tree["animations"][0] == before.tree["animations"][0]
    added = after.tree["animations"][1]
    assert [channel["target"]["node"] for channel in added["channels"]] == [0, 1]
    head, teeth = (after.accessor(sampler["output"])[:, 0] for sampler in added["samplers"])
    np.testing.assert_array_equal(head.reshape(-1, 2)[:, 1], line().channel("jawOpen"))
    np.testing.assert_array_equal(teeth, line().channel("jawOpen"))
    assert not head.reshape(-1, 2)[:, 0].any()
    assert set(load(tmp_path / "a.glb").channels) == {"browUp", "JawOpen", "Teeth.jaw_open"}


def test_compressed_and_quantized_characters_are_kept_as_they_are(tmp_path, mine):
    glb = character()
    tree = copy.deepcopy(glb.tree)
    tree["extensionsRequired"] = ["EXT_meshopt_compression", "KHR_mesh_quantization"]
    tree["buffers"].append({"byteLength": 36, "extensions": {"EXT_meshopt_compression": {"fallback": True}}})
    packed = {"buffer": 0, "byteLength": 36, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"}
    tree["bufferViews"][0] = {
        "buffer": 1,
        "byteLength": 36,
        "extensions": {"EXT_meshopt_compression": packed},
    }
    tree["accessors"][0]["componentType"] = 5122
    save(line(), tmp_path / "a.glb", character=mine(Glb(tree, glb.binary, "")))
    after = read_glb(tmp_path / "a.glb")
    assert after.tree["bufferViews"][:2] == tree["bufferViews"]
    assert after.tree["buffers"][1] == tree["buffers"][1]
    np.testing.assert_array_equal(load(tmp_path / "a.glb").channel("JawOpen"), line().channel("jawOpen"))


def test_vrm_expressions_move_their_targets(tmp_path, mine):
    glb = character(names=("Fcl_A", "Fcl_I"))
    binds = [{"node": 0, "index": 0, "weight": 0.5}]
    glb.tree["extensions"] = {"VRMC_vrm": {"expressions": {"preset": {"aa": {"morphTargetBinds": binds}}}}}
    animation = replace(line(), values=line().values[:, :2], channels=("aa", "ih"), rig="vrm")
    save(animation, tmp_path / "a.vrm", character=mine(glb))
    np.testing.assert_allclose(load(tmp_path / "a.vrm").channel("Fcl_A"), animation.channel("aa") / 2)
    with pytest.raises(OutputError, match=r"a\.vrm: a \.vrm needs your own character; name it"):
        save(animation, tmp_path / "a.vrm")


def test_characters_that_cannot_be_used(tmp_path, mine):
    glb = character()
    glb.tree["buffers"][0]["uri"] = "data:,"
    with pytest.raises(RigError, match=r"mine\.glb: its first buffer is outside the file; pack it with: npx"):
        save(line(), tmp_path / "a.glb", character=mine(glb))
    twice = character(names=("jawOpen", "x"), teeth=("a.jawOpen", "b.jawOpen"))
    with pytest.raises(
        RigError, match=r"the channel jawOpen fits two morph targets, 'a\.jawOpen' and 'b\.jawOp"
    ):
        save(line(), tmp_path / "a.glb", character=mine(twice))
    values = line().values.copy()
    values[0, 0] = np.inf
    with pytest.raises(OutputError, match=r"browDownLeft is not a finite number at 0\.000 s"):
        save(line().with_values(values), tmp_path / "a.glb", character=mine())
    assert not (tmp_path / "a.glb").exists()


def test_a_character_that_is_also_the_destination(mine):
    path = mine()
    save(only(line(), jawOpen=0.25), path, character=path)
    assert load(path).channel("JawOpen").max() == 0.25


def test_two_meshes_that_share_all_names(tmp_path, mine):
    """Both speak, and are read back as one; where another program moved them apart, that is told."""
    twins = character(names=("browUp", "JawOpen"), teeth=("browUp", "JawOpen"))
    path = tmp_path / "a.glb"
    save(only(line(), jawOpen=0.25), path, character=mine(twins))
    glb = read_glb(path)
    first, second = glb.tree["animations"][-1]["channels"]
    assert first["target"]["node"] != second["target"]["node"]
    again = load(path)
    assert again.channels == ("browUp", "JawOpen")
    np.testing.assert_allclose(again.channel("JawOpen"), 0.25)
    save(only(line(), jawOpen=0.5), tmp_path / "b.glb", character=mine(twins))
    other = read_glb(tmp_path / "b.glb")
    parted = glb.binary[: -len(other.binary) // 4] + other.binary[-len(other.binary) // 4 :]
    path.write_bytes(glb_bytes(glb.tree, parted))
    with pytest.raises(
        OutputError, match=r"a\.glb: two of its meshes move JawOpen differently; key them alike"
    ):
        load(path)
