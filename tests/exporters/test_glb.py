import json
import os
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from animations import line, only

from phonanim.errors import OutputError, RigError
from phonanim.exporters import load, save
from phonanim.exporters._twin import OURS
from phonanim.exporters.glb import write
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.rig.head import SHIPPED, load_head
from phonanim.rig.neck import TURNS


@pytest.fixture
def spoken(tmp_path):
    path = tmp_path / "hello.glb"
    save(line(), path)
    return path


def test_the_head_is_untouched(spoken):
    before, after = read_glb(SHIPPED), read_glb(spoken)
    assert after.binary.startswith(before.binary)
    for key, value in before.tree.items():
        if key != "buffers":
            assert (
                after.tree[key][: len(value)] == value
                if isinstance(value, list)
                else after.tree[key] == value
            )
    np.testing.assert_array_equal(load_head(spoken).deltas, load_head().deltas)


def test_one_animation_with_names_times_and_labels(spoken):
    glb = read_glb(spoken)
    (animation,) = glb.tree["animations"]
    assert animation["name"] == "hello"
    (channel, turn), (sampler, _) = animation["channels"], animation["samplers"]
    assert glb.tree["nodes"][turn["target"]["node"]]["name"] == "Head"
    assert turn["target"]["path"] == "rotation"
    assert channel["target"] == {"node": 0, "path": "weights"}
    np.testing.assert_allclose(glb.accessor(sampler["input"])[:, 0], line().times, atol=1e-6)
    weights = glb.accessor(sampler["output"]).reshape(61, len(load_head().targets))
    names = glb.tree["meshes"][0]["extras"]["targetNames"]
    np.testing.assert_array_equal(weights[:, names.index("jawOpen")], line().channel("jawOpen"))
    assert animation["extras"]["phones"][2] == ["ə", 0.2, 0.3]
    assert animation["extras"]["words"] == [["hello", 0.1, 0.7]]


def test_a_second_animation_stands_beside_the_first(spoken, tmp_path):
    write(only(line(), jawOpen=0.5), tmp_path / "again.glb", character=spoken)
    tree = read_glb(tmp_path / "again.glb").tree
    assert [animation["name"] for animation in tree["animations"]] == ["hello", "again"]
    assert load(tmp_path / "again.glb").channel("jawOpen").tolist() == [0.5] * 61


def test_a_second_run_replaces_its_own_animation(spoken, tmp_path):
    again = tmp_path / "again" / "hello.glb"
    again.parent.mkdir()
    write(line(), again, character=spoken)
    assert again.read_bytes() == spoken.read_bytes()
    write(only(line(frames=30), jawOpen=0.5), again, character=spoken)
    (animation,) = read_glb(again).tree["animations"]
    assert animation["name"] == "hello"
    assert load(again).channel("jawOpen").tolist() == [0.5] * 30
    assert again.stat().st_size < spoken.stat().st_size
    write(line(), tmp_path / "second.glb", character=spoken)
    write(line(seed=1), again, character=tmp_path / "second.glb")  # whose data are no longer the last
    assert [one["name"] for one in read_glb(again).tree["animations"]] == ["second", "hello"]
    np.testing.assert_allclose(load(again).channel("jawOpen"), line(seed=1).channel("jawOpen"))


def test_animations_of_others_stay(spoken, tmp_path):
    glb = read_glb(spoken)
    glb.tree["animations"][0].pop("extras")
    spoken.write_bytes(glb_bytes(glb.tree, glb.binary))
    again = tmp_path / "again" / "hello.glb"
    again.parent.mkdir()
    write(line(), again, character=spoken)
    assert [one["name"] for one in read_glb(again).tree["animations"]] == ["hello", "hello"]
    glb.tree["animations"] = [
        {"name": "hello", "samplers": [], "channels": [], "extras": dict.fromkeys(OURS)}
    ]
    spoken.write_bytes(glb_bytes(glb.tree, glb.binary))
    write(line(), again, character=spoken)
    assert len(read_glb(again).tree["animations"]) == 1


@pytest.mark.parametrize("place", ["nodes", "meshes"])
def test_weights_at_rest_of_other_shapes_are_kept(tmp_path, place):
    glb = read_glb(SHIPPED)
    names = load_head().targets
    tree = json.loads(json.dumps(glb.tree))
    tree[place][0]["weights"] = [0.25 if name == "jawOpen" else 0.0 for name in names]
    tree[place][0]["weights"][-1] = 0.125
    (tmp_path / "posed.glb").write_bytes(glb_bytes(tree, glb.binary))
    save(only(line(), jawOpen=0.5), tmp_path / "a.glb", character=tmp_path / "posed.glb")
    found = load(tmp_path / "a.glb")
    assert set(found.channel("jawOpen").tolist()) == {0.5}
    assert set(found.channel(names[-1]).tolist()) == {0.125}


def test_time_before_zero_is_moved(tmp_path):
    save(replace(line(), start=-0.5), tmp_path / "a.glb")
    glb = read_glb(tmp_path / "a.glb")
    assert glb.accessor(glb.tree["animations"][0]["samplers"][0]["input"]).min() == 0
    assert load(tmp_path / "a.glb").start == -0.5


def test_characters_that_cannot_be_animated(tmp_path):
    animation = replace(line(), channels=tuple(f"x{i}" for i in range(52)))
    message = r"head\.glb: has no morph target named like x0, x1, x2 \.\.\.; name a --character"
    with pytest.raises(RigError, match=message):
        save(animation, tmp_path / "a.glb")
    assert not list(tmp_path.iterdir())


def test_files_without_an_animation(tmp_path):
    with pytest.raises(OutputError, match=r"head\.glb: has no animation of named morph targets"):
        load(SHIPPED)
    path = tmp_path / "a.glb"
    save(line(frames=1), path)
    assert len(load(path).values) == 1
    glb = read_glb(path)
    glb.tree["animations"][0].pop("extras")
    path.write_bytes(glb_bytes(glb.tree, glb.binary))
    with pytest.raises(OutputError, match=r"a\.glb: its animation has only one key"):
        load(path)


def edited(path, keys, values, interpolation):
    """The file at `path` with other keys in its animation, as another program would write it."""
    glb = read_glb(path)
    animation = glb.tree["animations"][0]
    animation["extras"] = {}
    sampler = animation["samplers"][0]
    sampler["interpolation"] = interpolation
    binary = glb.binary
    for name, array in (("input", keys), ("output", values)):
        spec = glb.tree["accessors"][sampler[name]]
        spec["count"] = array.size
        view = {"buffer": 0, "byteOffset": len(binary), "byteLength": array.nbytes}
        spec["bufferView"] = len(glb.tree["bufferViews"])
        glb.tree["bufferViews"].append(view)
        binary += array.astype("<f4").tobytes()
    path.write_bytes(glb_bytes(glb.tree, binary))


def test_other_programs_keys(spoken):
    keys = np.array([0, 0.1, 0.2, 0.5])
    jaw = load_head().targets.index("jawOpen")
    values = np.zeros((4, len(load_head().targets)))
    values[:, jaw] = [0, 1, 0, 0.6]
    edited(spoken, keys, values, "LINEAR")
    read = load(spoken)
    assert read.fps == pytest.approx(10, rel=1e-4)
    np.testing.assert_allclose(read.channel("jawOpen"), [0, 1, 0, 0.2, 0.4, 0.6], atol=1e-5)
    edited(spoken, keys, values, "STEP")
    np.testing.assert_allclose(load(spoken).channel("jawOpen"), [0, 1, 0, 0, 0, 0.6], atol=1e-5)
    tangents = np.stack([0 * values, values, 0 * values], axis=1)
    edited(spoken, keys, tangents, "CUBICSPLINE")
    eased = [0.6 * (3 - 2 * t) * t * t for t in (1 / 3, 2 / 3)]
    np.testing.assert_allclose(load(spoken).channel("jawOpen"), [0, 1, 0, *eased, 0.6], atol=1e-5)


def test_keys_stay_within_the_error(tmp_path):
    save(line(fps=120, frames=241), tmp_path / "dense.glb")
    save(line(fps=120, frames=241), tmp_path / "keys.glb", keys=0.05)
    assert (tmp_path / "keys.glb").stat().st_size < (tmp_path / "dense.glb").stat().st_size
    glb = read_glb(tmp_path / "keys.glb")
    sampler = glb.tree["animations"][0]["samplers"][0]
    assert sampler["interpolation"] == "LINEAR"
    assert glb.tree["accessors"][sampler["input"]]["count"] < 241
    again = load(tmp_path / "keys.glb")
    assert again.fps == 120
    turns = [name in TURNS for name in again.channels]
    missed = np.abs(again.values - line(fps=120, frames=241).values).max(axis=0)
    assert (missed <= np.where(turns, 10 * 0.05, 0.05) + 2e-4).all()


NODE = shutil.which("node")


def has_validator():
    code = "require.resolve('gltf-validator')"
    return NODE is not None and subprocess.run([NODE, "-e", code], capture_output=True).returncode == 0


@pytest.mark.skipif(not has_validator(), reason="needs node and the npm package gltf-validator on NODE_PATH")
def test_the_khronos_validator_finds_nothing(spoken, root):
    script = root / "scripts" / "check_glb.cjs"
    others = [spoken.with_name(f"a{suffix}") for suffix in (".gltf", ".vrma")]
    for path in others:
        save(line(), path)
    again = spoken.with_name("again.glb")
    save(line(), again, character=spoken)
    files = [SHIPPED, spoken, again, *others]
    done = subprocess.run([NODE, script, *files], capture_output=True, text=True, env=os.environ)
    assert done.returncode == 0, done.stdout
    assert done.stdout.count("0 errors, 0 warnings") == len(files)


def test_the_json_is_plain(spoken):
    json.dumps(read_glb(spoken).tree, allow_nan=False)


def test_an_animation_per_mesh_is_one(spoken, tmp_path):
    """As Blender writes it: an action for every mesh, and a shorter one that was there before."""
    glb = read_glb(spoken)
    (entry,) = glb.tree["animations"]
    (channel,) = (one for one in entry["channels"] if one["target"]["path"] == "weights")
    node = glb.tree["nodes"][channel["target"]["node"]]
    glb.tree["nodes"].append({**node, "name": "second"})
    second = {**channel, "target": {**channel["target"], "node": len(glb.tree["nodes"]) - 1}}
    apart = [{**entry, "channels": [one], "extras": {}} for one in (channel, second)]
    glb.tree["animations"] = apart
    path = tmp_path / "apart.glb"
    path.write_bytes(glb_bytes(glb.tree, glb.binary))
    again = load(path)
    assert again.fps == 60
    for name in again.channels:
        np.testing.assert_allclose(again.channel(name), load(spoken).channel(name))
