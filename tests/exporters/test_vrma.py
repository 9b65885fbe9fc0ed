import json
import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from animations import line, only
from avatars import write_vrm0, write_vrm1

from phonanim.errors import OutputError
from phonanim.exporters import load, save
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.rig.head import SHIPPED
from phonanim.rig.neck import TURNS


def spoken(*names):
    """The line with other names for its first channels."""
    animation = line()
    return replace(animation, channels=(*names, *animation.channels[len(names) :]))


@pytest.fixture
def vrma(tmp_path):
    path = tmp_path / "hello.vrma"
    save(spoken("aa", "lookUp", "ih"), path)
    return path


def test_expressions_are_nodes_whose_x_is_the_weight(vrma):
    glb = read_glb(vrma)
    extension = glb.tree["extensions"]["VRMC_vrm_animation"]
    assert extension["specVersion"] == "1.0"
    assert set(extension["expressions"]["preset"]) == {"aa", "ih"}
    assert "jawOpen" in extension["expressions"]["custom"]
    assert not {"lookUp", *TURNS} & set(extension["expressions"]["custom"])
    (animation,) = glb.tree["animations"]
    node = extension["expressions"]["custom"]["jawOpen"]["node"]
    assert glb.tree["nodes"][node]["name"] == "jawOpen"
    (sampler,) = (
        animation["samplers"][channel["sampler"]]
        for channel in animation["channels"]
        if channel["target"] == {"node": node, "path": "translation"}
    )
    shifts = glb.accessor(sampler["output"])
    np.testing.assert_array_equal(shifts[:, 0], line().channel("jawOpen"))
    assert not shifts[:, 1:].any()


def test_the_skeleton_has_the_bones_that_are_required_in_a_pose_that_stands(vrma):
    tree = read_glb(vrma).tree
    bones = tree["extensions"]["VRMC_vrm_animation"]["humanoid"]["humanBones"]
    sides = ("UpperLeg", "LowerLeg", "Foot", "UpperArm", "LowerArm", "Hand")
    assert {"hips", "spine", "head"} | {side + part for side in ("left", "right") for part in sides} <= set(
        bones
    )
    nodes = tree["nodes"]
    assert nodes[bones["hips"]["node"]]["translation"][1] > 0.5
    assert (
        nodes[bones["leftUpperArm"]["node"]]["translation"][0]
        > 0
        > nodes[bones["rightHand"]["node"]]["translation"][0]
    )
    turned = [
        c["target"]["node"] for c in tree["animations"][0]["channels"] if c["target"]["path"] == "rotation"
    ]
    assert turned == [bones["head"]["node"]]


def test_weights_are_within_the_limits_of_the_format(tmp_path):
    save(only(line(), jawOpen=1.5, jawLeft=-0.5), tmp_path / "a.vrma")
    again = load(tmp_path / "a.vrma")
    assert set(again.channel("jawOpen").tolist()) == {1.0}
    assert set(again.channel("jawLeft").tolist()) == {0.0}


@pytest.mark.parametrize("make", [write_vrm0, write_vrm1])
def test_an_avatar_has_its_own_spelling(tmp_path, make):
    avatar = make(tmp_path / "a.vrm")
    save(spoken("aa"), tmp_path / "a.vrma", character=avatar)
    again = load(tmp_path / "a.vrma")
    assert set(again.channels) == {"aa", "JawLeft", "Mouth_Smile_Left", *TURNS}
    np.testing.assert_allclose(again.channel("JawLeft"), line().channel("jawLeft"), atol=1e-6)
    np.testing.assert_allclose(again.channel("headYaw"), line().channel("headYaw"), atol=1e-5)


def test_avatars_without_the_expressions_of_the_rig(tmp_path):
    vowels = replace(only(line(), jawOpen=1.0), values=line().values[:, :1], channels=("oh",))
    avatar = write_vrm1(tmp_path / "a.vrm")
    with pytest.raises(
        OutputError, match=r"is an expression of .*a\.vrm: its expressions are aa, ou, .*--rig"
    ):
        save(vowels, tmp_path / "a.vrma", character=avatar)
    with pytest.raises(OutputError, match=r"head\.glb: it has no VRM expression; choose another --rig"):
        save(vowels, tmp_path / "a.vrma", character=SHIPPED)
    assert [path.name for path in tmp_path.iterdir()] == ["a.vrm"]


NODE, PACKAGES = shutil.which("node"), Path(os.environ.get("NODE_PATH", "node_modules"))


@pytest.mark.skipif(
    NODE is None or not (PACKAGES / "@pixiv/three-vrm-animation").is_dir(),
    reason="needs node and the npm packages three, @pixiv/three-vrm and its animation on NODE_PATH",
)
@pytest.mark.parametrize("make", [write_vrm0, write_vrm1])
def test_three_vrm_shows_the_weights(tmp_path, root, make):
    avatar = make(tmp_path / "a.vrm")
    save(spoken("aa"), tmp_path / "a.vrma", character=avatar)
    save(spoken("aa"), tmp_path / "a.json")
    files = [avatar, tmp_path / "a.vrma", tmp_path / "a.json"]
    done = subprocess.run(
        [NODE, root / "scripts/check_vrma.mjs", *files], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith("3 expressions, ")


def test_keys_are_few(vrma, tmp_path):
    save(only(line(), jawOpen=0.5), tmp_path / "few.vrma", keys=0.01)
    glb = read_glb(tmp_path / "few.vrma")
    assert max(entry["count"] for entry in glb.tree["accessors"]) <= 2
    assert load(tmp_path / "few.vrma").channel("jawOpen").tolist() == [0.5] * 61


def test_files_that_are_no_animation_of_expressions(vrma, tmp_path):
    with pytest.raises(OutputError, match=r"has no animation of VRM expressions"):
        (tmp_path / "b.vrma").write_bytes(SHIPPED.read_bytes())
        load(tmp_path / "b.vrma")
    glb = read_glb(vrma)
    tree = json.loads(json.dumps(glb.tree))
    tree["animations"][0]["channels"][0]["sampler"] = 999
    vrma.write_bytes(glb_bytes(tree, glb.binary))
    with pytest.raises(OutputError, match=r"hello\.vrma: its animation is damaged: "):
        load(vrma)
    tree = json.loads(json.dumps(glb.tree))
    tree["animations"][0].pop("extras")
    for sampler in tree["animations"][0]["samplers"]:
        for accessor in sampler["input"], sampler["output"]:
            tree["accessors"][accessor]["count"] = 1
    vrma.write_bytes(glb_bytes(tree, glb.binary))
    with pytest.raises(OutputError, match=r"hello\.vrma: its animation has only one key"):
        load(vrma)
