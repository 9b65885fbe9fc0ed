"""VRM avatars for tests: the shipped head on a skeleton, with expressions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from phonanim.exporters.vrma import skeleton_nodes
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.rig.head import SHIPPED
from phonanim.rig.morphs import target_names

PRESETS = {"aa": "jawOpen", "ou": "mouthPucker", "blinkLeft": "eyeBlinkLeft"}
CUSTOM = {"JawLeft": "jawLeft", "Mouth_Smile_Left": "mouthSmileLeft"}


def write_vrm1(path: Path) -> Path:
    """A VRM 1.0 whose expressions, `PRESETS` and `CUSTOM`, move one shape of the shipped head each."""
    tree, binary, bones, groups = _avatar()
    expressions = {
        kind: {
            name: {
                "morphTargetBinds": [{"node": node, "index": index, "weight": 1.0} for node, index in binds]
            }
            for name, binds in found.items()
        }
        for kind, found in groups.items()
    }
    meta = {
        "name": "test",
        "version": "1",
        "authors": ["phonanim"],
        "licenseUrl": "https://vrm.dev/licenses/1.0/",
    }
    humanoid = {"humanBones": {name: {"node": node} for name, node in bones.items()}}
    vrm = {"specVersion": "1.0", "meta": meta, "humanoid": humanoid, "expressions": expressions}
    return _write(path, tree, binary, "VRMC_vrm", vrm)


def write_vrm0(path: Path) -> Path:
    """The same as a VRM 0.x, whose mouth is called a and u."""
    tree, binary, bones, groups = _avatar()
    letters = {"aa": "a", "ou": "u", "blinkLeft": "blink_l"}
    meshes = [entry.get("mesh") for entry in tree["nodes"]]
    listed = [
        {
            "name": name,
            "presetName": letters.get(name, "unknown"),
            "binds": [{"mesh": meshes[node], "index": index, "weight": 100} for node, index in binds],
        }
        for found in groups.values()
        for name, binds in found.items()
    ]
    vrm = {
        "meta": {"title": "test", "author": "phonanim"},
        "humanoid": {"humanBones": [{"bone": name, "node": node} for name, node in bones.items()]},
        "blendShapeMaster": {"blendShapeGroups": listed},
    }
    return _write(path, tree, binary, "VRM", vrm)


def _avatar() -> tuple[dict[str, Any], bytes, dict[str, int], dict[str, Any]]:
    """The tree of the head with bones, its binary chunk, the bones, and the targets of each expression."""
    glb = read_glb(SHIPPED)
    first = len(glb.tree["nodes"])
    bones = [
        {**bone, "children": [child + first for child in bone.get("children", [])]}
        for bone in skeleton_nodes()
    ]
    bones = [{key: value for key, value in bone.items() if value != []} for bone in bones]
    tree = {**glb.tree, "nodes": [*glb.tree["nodes"], *bones]}
    scene = tree["scenes"][0]
    tree["scenes"] = [{**scene, "nodes": [*scene["nodes"], first]}]
    groups = {
        kind: {name: _binds(tree, target) for name, target in found.items()}
        for kind, found in (("preset", PRESETS), ("custom", CUSTOM))
    }
    return tree, glb.binary, {bone["name"]: first + n for n, bone in enumerate(bones)}, groups


def _binds(tree: dict[str, Any], target: str) -> list[tuple[int, int]]:
    """Every node and target of this name."""
    return [
        (node, target_names(tree["meshes"][entry["mesh"]]).index(target))
        for node, entry in enumerate(tree["nodes"])
        if "mesh" in entry and target in target_names(tree["meshes"][entry["mesh"]])
    ]


def _write(path: Path, tree: dict[str, Any], binary: bytes, name: str, vrm: dict[str, Any]) -> Path:
    tree["extensions"] = {**tree.get("extensions", {}), name: vrm}
    tree["extensionsUsed"] = [*tree.get("extensionsUsed", []), name]
    path.write_bytes(glb_bytes(tree, binary))
    return path
