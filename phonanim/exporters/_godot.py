"""Where Godot 4 puts the nodes of a glTF file when it imports one.

Bones become bones of a Skeleton3D below the node above them, skinned meshes children of that skeleton,
and meshes that hang on a bone children of a BoneAttachment3D. Names are made unique, those of bones last.
Source: the importer of Godot 4.6 (modules/gltf), and the scenes that it makes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from phonanim.media.glb import Glb

SKELETON = "Skeleton3D"
FORBIDDEN = re.compile(r'[.:@/"%]')  # in the name of a node
FORBIDDEN_IN_BONES = re.compile(r"[:/]")


@dataclass(frozen=True)
class Scene:
    """The names of all nodes as Godot spells them, and which nodes are bones."""

    glb: Glb
    names: dict[int, str]
    bones: set[int]

    def mesh(self, node: int) -> str:
        """The path of a node's mesh from the root of the scene."""
        skin = self.glb.tree["nodes"][node].get("skin")
        joints = [] if skin is None else self.glb.tree["skins"][skin]["joints"]
        return _joined(self.skeleton(joints[0]) if joints else self._above(node), self.names[node])

    def bone(self, node: int) -> str:
        """The path of a node that is a bone, with its skeleton, or of another node."""
        if node not in self.bones:
            return _joined(self._above(node), self.names[node])
        return f"{self.skeleton(node)}:{self.names[node]}"

    def skeleton(self, bone: int) -> str:
        """The path of the skeleton of a bone: one for all bones below the same node."""
        while self.glb.parents.get(bone) in self.bones:
            bone = self.glb.parents[bone]
        return _joined(self._above(bone), SKELETON)

    def _above(self, node: int) -> str:
        """The path of what a node stands below."""
        parent = self.glb.parents.get(node)
        if parent is None:
            return ""
        if parent in self.bones:
            return _joined(self.skeleton(parent), self.names[parent])
        return _joined(self._above(parent), self.names[parent])


def read_scene(glb: Glb) -> Scene:
    """The scene that Godot makes of a file."""
    bones, nodes = _bones(glb), glb.tree["nodes"]
    names: dict[int, str] = {}
    taken: set[str] = set()
    for node in sorted(range(len(nodes)), key=lambda node: (node in bones, node)):
        name = nodes[node].get("name", "")
        if node in bones:
            plain, before = FORBIDDEN_IN_BONES.sub("_", name or "bone"), "_"
        else:
            plain, before = FORBIDDEN.sub("_", name or ("Mesh" if "mesh" in nodes[node] else "Node")), ""
        names[node] = _unique(plain, before, taken)
        taken.add(names[node])
    return Scene(glb, names, bones)


def _bones(glb: Glb) -> set[int]:
    """The joints of all skins, and the nodes between them."""
    joints = {joint for skin in glb.tree.get("skins", ()) for joint in skin["joints"]}
    bones = set(joints)
    for joint in joints:
        way, node = [joint], glb.parents.get(joint)
        while node is not None:
            way.append(node)
            if node in joints:
                bones.update(way)
            node = glb.parents.get(node)
    return bones


def _unique(name: str, before: str, taken: set[str]) -> str:
    found, number = name, 1
    while found in taken:
        number += 1
        found = f"{name}{before}{number}"
    return found


def _joined(above: str, name: str) -> str:
    return f"{above}/{name}" if above else name
