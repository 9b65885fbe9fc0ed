import copy
import os
import struct

import numpy as np
import pytest
from animations import line

from phonanim.errors import RigError
from phonanim.exporters import load, save
from phonanim.media.glb import Glb, glb_bytes, kept_glb, parse_glb, read_glb
from phonanim.rig.character import load_character
from phonanim.rig.head import SHIPPED, load_head


def glb_of(accessor, views, binary):
    return Glb({"accessors": [accessor], "bufferViews": views}, binary, "a.glb")


def test_bytes_round_trip_and_are_aligned():
    data = glb_bytes({"asset": {"version": "2.0"}, "name": "ü"}, [b"abc", b"de"])
    glb = parse_glb(data, "a.glb")
    assert glb.tree == {"asset": {"version": "2.0"}, "name": "ü"}
    assert glb.binary == b"abcde\0\0\0"
    assert len(data) % 4 == 0
    assert struct.unpack_from("<I", data, 8) == (len(data),)


def test_interleaved_accessors():
    rows = np.arange(12, dtype="<f4").reshape(2, 6)
    views = [{"buffer": 0, "byteStride": 24}]
    spec = {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 2, "type": "VEC3"}
    np.testing.assert_array_equal(glb_of(spec, views, rows.tobytes()).accessor(0), rows[:, 3:])


def test_normalized_accessors():
    spec = {"bufferView": 0, "componentType": 5120, "count": 3, "type": "SCALAR", "normalized": True}
    values = np.array([127, 0, -128], "<i1").tobytes()
    np.testing.assert_array_equal(glb_of(spec, [{"buffer": 0}], values).accessor(0)[:, 0], [1, 0, -1])


def test_sparse_accessors():
    binary = struct.pack("<2H2f", 1, 3, 0.5, 0.25)
    sparse = {
        "count": 2,
        "indices": {"bufferView": 0, "componentType": 5123},
        "values": {"bufferView": 0, "byteOffset": 4},
    }
    spec = {"componentType": 5126, "count": 4, "type": "SCALAR", "sparse": sparse}
    found = glb_of(spec, [{"buffer": 0}], binary).accessor(0)
    np.testing.assert_array_equal(found[:, 0], [0, 0.5, 0, 0.25])
    spec["count"] = 3
    with pytest.raises(RigError, match=r"a\.glb: a sparse accessor points past its end"):
        glb_of(spec, [{"buffer": 0}], binary).accessor(0)


def test_accessors_that_cannot_be_read():
    spec = {"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR"}
    with pytest.raises(RigError, match=r"a\.glb: an accessor reaches past the end of the file"):
        glb_of(spec, [{"buffer": 0}], b"1234567").accessor(0)
    packed = {"buffer": 0, "extensions": {"EXT_meshopt_compression": {}}}
    for view in (packed, {"buffer": 1}):
        with pytest.raises(
            RigError,
            match=r"compressed .*; save an uncompressed copy with: npx|outside the file; pack it with: npx",
        ):
            glb_of(spec, [view], b"12345678").accessor(0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: b"", r"is not a binary glTF 2\.0 file; export the character as \.glb"),
        (lambda data: b"\0" * 40, r"is not a binary glTF 2\.0 file"),
        (lambda data: data[:-4], r"is truncated or padded"),
        (lambda data: data.replace(b'"asset"', b"'asset'"), r"has no readable JSON chunk; export it again"),
    ],
)
def test_damaged_files(tmp_path, change, message):
    path = tmp_path / "a.glb"
    path.write_bytes(change(SHIPPED.read_bytes()))
    with pytest.raises(RigError, match=message):
        read_glb(path)


def test_a_missing_file(tmp_path):
    with pytest.raises(RigError, match=r"none\.glb: cannot be read: No such file"):
        read_glb(tmp_path / "none.glb")


def draco(tree):
    """The tree of a file whose first primitive's data are in a Draco blob: its accessors point nowhere."""
    tree["extensionsUsed"] = tree["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    primitive = tree["meshes"][0]["primitives"][0]
    for number in (primitive["indices"], *primitive["attributes"].values()):
        tree["accessors"][number].pop("bufferView", None)
    return tree


def test_compressed_meshes_are_not_read_as_noughts(tmp_path):
    shipped = read_glb(SHIPPED)
    glb = Glb(draco(copy.deepcopy(shipped.tree)), shipped.binary, "a.glb")
    message = r"compressed \(KHR_draco_mesh_compression\); save an uncompressed copy with: npx"
    with pytest.raises(RigError, match=message):
        glb.accessor(glb.tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"])
    path = tmp_path / "a.glb"
    path.write_bytes(glb_bytes(glb.tree, glb.binary))
    for suffix in (".usda", ".html"):
        with pytest.raises(RigError, match=message):
            save(line(), tmp_path / f"a{suffix}", character=path)
    save(line(), tmp_path / "b.glb", character=path)  # passes through untouched
    np.testing.assert_allclose(load(tmp_path / "b.glb").values, line().values, atol=1e-7)


def quantized(source):
    """The shipped head with positions in 16-bit steps and a smaller box (KHR_mesh_quantization)."""
    tree, pieces = copy.deepcopy(source.tree), [source.binary]
    tree["extensionsUsed"] = tree["extensionsRequired"] = ["KHR_mesh_quantization"]
    for primitive in tree["meshes"][0]["primitives"]:
        number = primitive["attributes"]["POSITION"]
        steps = np.rint(source.accessor(number) * 65534 - 32767 * np.array([0, 1, 0])).astype("<i2")
        padded = np.pad(steps, [(0, 0), (0, 1)])
        offset = sum(map(len, pieces))
        view = {"buffer": 0, "byteOffset": offset, "byteLength": padded.nbytes, "byteStride": 8}
        tree["bufferViews"].append(view)
        changed = {
            "componentType": 5122,
            "normalized": True,
            "byteOffset": 0,
            "bufferView": len(tree["bufferViews"]) - 1,
        }
        tree["accessors"][number] |= changed
        pieces.append(padded.tobytes())
        for target in primitive["targets"]:
            target.pop("NORMAL", None)
    node = next(node for node in tree["nodes"] if node.get("mesh") == 0)
    del node["skin"]  # a skinned mesh stands where its skeleton puts it
    node |= {"scale": [0.5, 0.5, 0.5], "translation": [0.0, 0.5, 0.0]}
    tree["buffers"][0]["byteLength"] = sum(map(len, pieces))
    return glb_bytes(tree, pieces)


def test_quantized_meshes_stand_where_their_node_puts_them(tmp_path):
    path = tmp_path / "a.glb"
    path.write_bytes(quantized(read_glb(SHIPPED)))
    np.testing.assert_allclose(load_character(path).vertices, load_head().vertices, atol=2e-5)


def test_a_file_is_kept_until_it_changes(tmp_path):
    path = tmp_path / "a.glb"

    def put(name, seconds):
        path.write_bytes(glb_bytes({"asset": {"version": "2.0"}, "name": name}, b""))
        os.utime(path, (seconds, seconds))

    put("one", 1e9)
    first = kept_glb(path)
    assert kept_glb(path) is first
    put("two", 1e9 + 1)
    assert kept_glb(path).tree["name"] == "two"
    path.write_bytes(glb_bytes({"asset": {"version": "2.0"}, "name": "now"}, b""))
    assert kept_glb(path) is not kept_glb(path)  # it may change again within the same instant of the clock
    path.unlink()
    with pytest.raises(RigError, match="a.glb: cannot be read: No such file"):
        kept_glb(path)


def test_animations_leave_what_is_kept_as_it_was(tmp_path):
    before = copy.deepcopy(kept_glb(SHIPPED).tree)
    for name in ("a.glb", "a.gltf", "a.anim", "a.unity.anim", "a.tres"):
        save(line(), tmp_path / name)
    assert kept_glb(SHIPPED).tree == before
