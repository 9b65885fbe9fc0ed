"""Paths in the scenes that Godot 4 imports; what it was seen to make of these files is the expectation."""

import copy
import re
import shutil
import subprocess

import pytest
from animations import line, only

from phonanim.exporters import save
from phonanim.exporters._godot import read_scene
from phonanim.media.glb import Glb, glb_bytes, read_glb
from phonanim.rig.head import SHIPPED

HEAD, NECK, BONE = 0, 1, 2  # the nodes of the shipped head


def changed(change):
    """The shipped head with other nodes."""
    glb = read_glb(SHIPPED)
    tree = copy.deepcopy(glb.tree)
    change(tree["nodes"], tree)
    return Glb(tree, glb.binary, glb.source)


def unskinned(nodes, tree):
    """The face and an eye hang on the bone of the head, as in characters of few parts."""
    del nodes[HEAD]["skin"]
    nodes.append({"name": "eye", "mesh": 0})
    nodes[BONE]["children"] = [HEAD, 5]
    tree["scenes"][0]["nodes"] = [NECK, 3, 4]


def odd_names(nodes, tree):
    """Names that Godot changes: forbidden characters, and a bone that is called as a mesh."""
    nodes[HEAD]["name"], nodes[3]["name"] = "He.ad:1", "Head"


def nodes_between(nodes, tree):
    """A node between two bones becomes a bone."""
    nodes += [{"name": "between", "children": [BONE]}, {"name": "Armature", "children": [HEAD, NECK]}]
    nodes[NECK]["children"] = [5]
    tree["scenes"][0]["nodes"] = [6, 3, 4]


def few_joints(nodes, tree):
    """The only joint is deep in the tree, and the mesh has no name."""
    del nodes[HEAD]["name"]
    nodes += [{"name": "Arm", "children": [NECK]}, {"children": [5, HEAD]}]
    tree["skins"][0]["joints"] = [BONE]
    tree["scenes"][0]["nodes"] = [6, 3, 4]


@pytest.mark.parametrize(
    ("change", "mesh", "bone"),
    [
        (lambda nodes, tree: None, "Skeleton3D/head", "Skeleton3D:Head"),
        (unskinned, "Skeleton3D/Head/head", "Skeleton3D:Head"),
        (odd_names, "Skeleton3D/He_ad_1", "Skeleton3D:Head_2"),
        (nodes_between, "Armature/Skeleton3D/head", "Armature/Skeleton3D:Head"),
        (few_joints, "Node/Arm/Neck/Skeleton3D/Mesh", "Node/Arm/Neck/Skeleton3D:Head"),
    ],
)
def test_paths_are_those_of_the_imported_scene(change, mesh, bone):
    scene = read_scene(changed(change))
    assert (scene.mesh(HEAD), scene.bone(BONE)) == (mesh, bone)


def test_a_head_that_is_no_bone_turns_as_a_node(tmp_path):
    scene = read_scene(changed(lambda nodes, tree: tree.pop("skins")))
    assert scene.bone(BONE) == "Neck/Head"


def test_shapes_are_called_as_the_importer_calls_them(tmp_path):
    def rename(nodes, tree):
        names = tree["meshes"][0]["extras"]["targetNames"]
        names[names.index("jawOpen")] = "blend:jawOpen"

    glb = changed(rename)
    hero = tmp_path / "hero.glb"
    hero.write_bytes(glb_bytes(glb.tree, [glb.binary]))
    save(only(line(), jawOpen=0.5), tmp_path / "a.tres", character=hero)
    assert "Skeleton3D/head:blend_shapes/blend_jawOpen" in (tmp_path / "a.tres").read_text()


GODOT4 = next(filter(None, map(shutil.which, ("godot4", "godot"))), None)


@pytest.mark.skipif(GODOT4 is None, reason="needs Godot 4")
@pytest.mark.parametrize("change", [lambda nodes, tree: None, unskinned, odd_names, nodes_between])
def test_godot_4_finds_every_track(tmp_path, root, change):
    glb = changed(change)
    hero = tmp_path / "hero.glb"
    hero.write_bytes(glb_bytes(glb.tree, [glb.binary]))
    for name in ("line.tres", "line.glb"):
        save(line(), tmp_path / name, character=hero, keys=0)
    command = [GODOT4, "--headless", "-s", root / "scripts" / "check_godot4.gd", "--"]
    command += [f"--scene={tmp_path / 'line.glb'}", f"--animation={tmp_path / 'line.tres'}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stdout
    assert re.search(r"\d+ tracks, 0 without a place", done.stdout)
