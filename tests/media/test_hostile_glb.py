"""GLB files that no program writes: each is refused in one line, and none takes time or memory."""

import copy

import numpy as np
import pytest
from animations import line

from phonanim.errors import RigError
from phonanim.exporters import save
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.media.gltf import MAX_LEVELS, MAX_NODES, MAX_TARGETS
from phonanim.rig.character import load_bare_character, load_character
from phonanim.rig.head import load_head

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
TREE = {
    "asset": {"version": "2.0"},
    "buffers": [{"byteLength": 80}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
    ],
    "materials": [{"name": "skin"}],
    "meshes": [
        {
            "primitives": [
                {"attributes": {"POSITION": 0}, "indices": 1, "material": 0, "targets": [{"POSITION": 0}]}
            ],
            "extras": {"targetNames": ["jawOpen"]},
        }
    ],
    "nodes": [{"mesh": 0}, {"children": [0]}],
}
BINARY = POINTS.tobytes() + np.arange(3, dtype="<u2").tobytes() + bytes(38)


def changed(place, value, tree=TREE):
    """The tree with a value put at a place, given by its keys."""
    tree = copy.deepcopy(tree)
    at = tree
    for key in place[:-1]:
        at = at[key]
    at[place[-1]] = value
    return tree


PRIMITIVE = ("meshes", 0, "primitives", 0)
ACCESSOR = ("accessors", 0)
SPARSE = {
    "count": 10**10,
    "indices": {"bufferView": 1, "componentType": 5123},
    "values": {"bufferView": 0},
}
DAMAGED = [
    (("nodes",), [{"mesh": 0, "children": [0]}], "below itself"),
    (("nodes", 0, "children"), [1], "below itself"),
    (("nodes",), [{"children": [2]}, {"children": [2]}, {"mesh": 0}], r"nodes\[2\] has two parents"),
    (
        ("nodes",),
        [{"mesh": 0}, *({"children": [n]} for n in range(MAX_LEVELS + 1))],
        "below more than 256 others",
    ),
    (("nodes",), [{"mesh": 0}] * (MAX_NODES + 1), "it has 20001 nodes"),
    (("nodes",), {}, "nodes is dict; it is a list"),
    (("nodes", 0, "mesh"), 7, r"nodes\[0\].mesh is 7"),
    (("nodes", 0, "mesh"), True, r"nodes\[0\].mesh is True"),
    (("nodes", 0, "matrix"), [1] * 15, r"nodes\[0\].matrix is not a list of 16 numbers"),
    (("nodes", 0, "rotation"), ["a"] * 4, r"nodes\[0\].rotation is 'a'"),
    (("nodes", 0, "translation"), [1e300] * 3, r"nodes\[0\].translation is 1e\+300"),
    ((*ACCESSOR, "count"), 10**12, "its meshes would take"),
    ((*ACCESSOR, "count"), -3, r"accessors\[0\].count is -3"),
    ((*ACCESSOR, "count"), 0, "holds no positions that fit"),
    ((*ACCESSOR, "count"), 9, "reaches past the end of the file"),
    ((*ACCESSOR, "type"), "VEC9", r"accessors\[0\].type is none that glTF has"),
    ((*ACCESSOR, "type"), ["VEC3"], r"accessors\[0\].type is none that glTF has"),
    ((*ACCESSOR, "componentType"), 1, r"accessors\[0\].componentType is none that glTF has"),
    ((*ACCESSOR, "bufferView"), -1, r"accessors\[0\].bufferView is -1"),
    ((*ACCESSOR, "byteOffset"), -4, r"accessors\[0\].byteOffset is -4"),
    ((*ACCESSOR, "normalized"), 1, r"accessors\[0\].normalized is not true or false"),
    ((*ACCESSOR, "sparse"), SPARSE, "sparse with more values than it has"),
    ((*ACCESSOR, "sparse"), {"count": 1}, "has no indices"),
    (("bufferViews", 0, "byteStride"), 1, "the items of an accessor overlap"),
    (("bufferViews", 0, "byteOffset"), 10**9, "reaches past the end of the file"),
    ((*PRIMITIVE, "attributes"), {}, "holds a mesh without positions"),
    ((*PRIMITIVE, "attributes"), {"POSITION": 1}, "holds no positions that fit"),
    ((*PRIMITIVE, "attributes", "POSITION"), 5, r"attributes.POSITION is 5"),
    ((*PRIMITIVE, "indices"), 0, "without whole triangles"),
    ((*PRIMITIVE, "mode"), 1, "not of triangles"),
    ((*PRIMITIVE, "targets"), [{"POSITION": 1}], "holds no positions that fit"),
    ((*PRIMITIVE, "targets"), [{}] * (MAX_TARGETS + 1), r"meshes\[0\] has not one count of targets"),
    ((*PRIMITIVE, "targets"), [3], r"targets\[0\] is 3; it is a table"),
    (("meshes", 0, "primitives"), [], r"meshes\[0\] has not one count of targets"),
    (("materials", 0, "pbrMetallicRoughness"), {"baseColorFactor": 3}, "baseColorFactor is 3; it is a list"),
    (("extensions",), {"VRM": 3}, "extensions.VRM is 3; it is a table"),
    (
        ("extensions",),
        {"VRMC_vrm": {"expressions": {"preset": {"aa": {"morphTargetBinds": [{"node": 0, "index": 9}]}}}}},
        "its expression 'aa' moves a target that does not exist",
    ),
]


def written(path, tree, binary=BINARY):
    path.write_bytes(glb_bytes(tree, binary))
    return path


@pytest.mark.parametrize(("place", "value", "message"), DAMAGED)
def test_damaged_trees(tmp_path, place, value, message):
    path = written(tmp_path / "a.glb", changed(place, value))
    with pytest.raises(RigError, match=message) as caught:
        load_character(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_the_tree_itself_is_sound(tmp_path):
    path = written(tmp_path / "a.glb", TREE)
    for read in (load_character, load_bare_character, load_head):
        assert len(read(path).vertices) == 3
    assert load_character(written(path, changed(("meshes", 0, "extras"), [1]))).targets == ()


@pytest.mark.parametrize("tree", [[], None, 3, {"nodes": 3}, {"accessors": [3]}, {"meshes": [{}]}])
def test_json_that_is_no_gltf(tmp_path, tree):
    with pytest.raises(RigError, match=r"a\.glb: is damaged: "):
        read_glb(written(tmp_path / "a.glb", tree))


@pytest.mark.parametrize("far", [3e38, float("nan"), float("inf"), 2e6])
def test_positions_that_lie_nowhere(tmp_path, far):
    points = np.where(POINTS == 1, np.float32(far), POINTS)
    path = written(tmp_path / "a.glb", TREE, points.tobytes() + BINARY[36:])
    for read in (load_character, load_bare_character, load_head):
        with pytest.raises(RigError, match="holds positions that are not finite, or farther than"):
            read(path)


def test_corners_that_are_not_there(tmp_path):
    binary = BINARY[:36] + np.array([0, 1, 3], "<u2").tobytes() + BINARY[42:]
    with pytest.raises(RigError, match="has a triangle with a missing corner"):
        load_character(written(tmp_path / "a.glb", TREE, binary))


def test_colours_that_do_not_fit(tmp_path):
    tree = changed((*PRIMITIVE, "attributes"), {"POSITION": 0, "COLOR_0": 1})
    with pytest.raises(RigError, match="its vertex colours do not fit its points"):
        load_head(written(tmp_path / "a.glb", tree))


def test_targets_that_many_nodes_share_are_counted_for_each(tmp_path):
    tree = changed(("nodes",), [{"mesh": 0}] * 20_000)
    tree["meshes"][0]["primitives"][0]["targets"] *= 20
    with pytest.raises(RigError, match="its nodes draw more than 200000 accessors"):
        read_glb(written(tmp_path / "a.glb", tree))


def test_names_that_many_points_share_are_counted_for_each(tmp_path):
    """A mesh of many targets beside one of many points would need them all for each."""
    many = {"componentType": 5126, "count": 200_000, "type": "VEC3", "bufferView": 0}
    tree = changed(("accessors",), [*TREE["accessors"], many])
    tree["meshes"].append({"primitives": [{"attributes": {"POSITION": 2}, "targets": [{}]}]})
    tree["meshes"][1]["extras"] = {"targetNames": ["b"]}
    tree["meshes"][0]["primitives"][0]["targets"] = [{}] * 200
    tree["meshes"][0]["extras"]["targetNames"] = [f"a{number}" for number in range(200)]
    tree["nodes"].append({"mesh": 1})
    tree["meshes"][1]["primitives"][0]["indices"] = 1
    path = written(tmp_path / "a.glb", tree, BINARY + bytes(12 * 200_000))
    with pytest.raises(RigError, match="its meshes would take .* MB"):
        load_character(path)


@pytest.mark.parametrize("key", ["images", "buffers"])
def test_the_viewer_fetches_nothing(tmp_path, key):
    tree = {**TREE, key: [{"uri": "http://127.0.0.1:1/a.png"}]}
    path = written(tmp_path / "a.glb", tree)
    with pytest.raises(RigError, match=r"its 'http://127\.0\.0\.1:1/a\.png' is outside the file"):
        save(line(), tmp_path / "a.html", character=path)
    assert not (tmp_path / "a.html").exists()
