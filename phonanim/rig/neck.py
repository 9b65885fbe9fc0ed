"""Turn a head: by a bone of the character's file, or by a share for each vertex.

Turns are degrees, (frames, 3): pitch down, yaw to the character's left, roll to its right shoulder, about x
(left), y (up) and z (ahead) of glTF; roll is done first and yaw last.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE
from phonanim.errors import RigError
from phonanim.media.glb import Glb, node_transform
from phonanim.rig.morphs import plain_name

Array = NDArray[np.float64]

TURNS = ("headPitch", "headYaw", "headRoll")
"""The controls that turn a head, in degrees."""

BONE = re.compile(r"(^|[:_.\s])head$", re.IGNORECASE)
STILL = 1e-9  # degrees
FLAT = 1e-12  # of a scale: a smaller one is treated as zero


@dataclass(frozen=True)
class Neck:
    """How a head turns: about `pivot` (3,) metres, with the `share` (n,) of the turn for each vertex."""

    pivot: Array
    share: Array


@dataclass(frozen=True)
class Bone:
    """The node that turns a head, its rotation at rest and its parent's in the world, (4,) xyzw each."""

    node: int
    rest: Array
    parent: Array

    def rotations(self, turns: Array) -> Array:
        """The node's own rotations for turns in the world, (frames, 3) degrees -> (frames, 4) xyzw."""
        back = self.parent * [-1, -1, -1, 1]
        return multiplied(multiplied(multiplied(back, quaternions(turns)), self.parent), self.rest)

    def turns(self, rotations: Array) -> Array:
        """The inverse of `rotations`, (frames, 4) -> (frames, 3) degrees."""
        back = self.parent * [-1, -1, -1, 1]
        undone = multiplied(multiplied(self.parent, rotations), self.rest * [-1, -1, -1, 1])
        return angles(multiplied(undone, back))


def is_turn(name: str) -> bool:
    """Whether a control turns the head, as rigs spell it: `headYaw`, `HeadYaw`."""
    return plain_name(name) in map(plain_name, TURNS)


def turns_of(values: NDArray[Any], channels: tuple[str, ...]) -> Array | None:
    """The turns in curves, (frames, channels) -> (frames, 3) degrees; None where the head does not turn."""
    names = [plain_name(name) for name in channels]
    turns = np.zeros((len(values), len(TURNS)))
    for column, name in enumerate(TURNS):
        if plain_name(name) in names:
            turns[:, column] = values[:, names.index(plain_name(name))]
    return turns if np.abs(turns).max(initial=0.0) > STILL else None


def turned(vertices: Array, neck: Neck | None, turn: Array | None) -> Array:
    """Turn vertices, (n, 3) metres, by (3,) degrees; unchanged without a neck or a turn."""
    if neck is None or turn is None:
        return vertices
    moved = (vertices - neck.pivot) @ matrix(turn).T + neck.pivot
    return np.asarray(vertices + neck.share[:, None] * (moved - vertices))


def matrix(turn: Array) -> Array:
    """The rotation of one turn, (3,) degrees -> (3, 3)."""
    x, y, z, w = quaternions(turn[None])[0]
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternions(turns: Array) -> Array:
    """Turns as quaternions, (frames, 3) degrees -> (frames, 4) xyzw."""
    half = np.radians(turns) / 2
    axes = []
    for axis in range(3):
        one = np.zeros((len(turns), 4))
        one[:, axis], one[:, 3] = np.sin(half[:, axis]), np.cos(half[:, axis])
        axes.append(one)
    return multiplied(multiplied(axes[1], axes[0]), axes[2])


def angles(rotations: Array) -> Array:
    """Quaternions as turns, (frames, 4) xyzw -> (frames, 3) degrees."""
    x, y, z, w = rotations.T
    pitch = np.arcsin(np.clip(2 * (x * w - y * z), -1, 1))
    yaw = np.arctan2(2 * (x * z + y * w), 1 - 2 * (x * x + y * y))
    roll = np.arctan2(2 * (x * y + z * w), 1 - 2 * (x * x + z * z))
    return np.degrees(np.stack([pitch, yaw, roll], axis=1))


def multiplied(first: Array, second: Array) -> Array:
    """Products of quaternions, (..., 4) xyzw each."""
    a, b = first[..., :3], second[..., :3]
    vector = first[..., 3:] * b + second[..., 3:] * a + np.cross(a, b)
    real = first[..., 3:] * second[..., 3:] - (a * b).sum(axis=-1, keepdims=True)
    return np.concatenate([vector, real], axis=-1)


def find_bone(glb: Glb) -> Bone | None:
    """The bone that turns a head: the humanoid one of VRM, or a joint of a skin named so. Raises RigError."""
    tree = glb.tree
    joints = sorted({joint for skin in tree.get("skins", ()) for joint in skin.get("joints", ())})
    named = [joint for joint in joints if BONE.search(tree["nodes"][joint].get("name", ""))]
    node = _humanoid_head(tree)
    if node is None and not named:
        return None
    node = named[0] if node is None else node
    above = glb.parents.get(node)
    rotation = np.eye(3) if above is None else node_transform(glb, above)[:3, :3]
    if "VRM" in tree.get("extensions", {}):
        rotation = np.diag([-1.0, 1.0, -1.0]) @ rotation  # VRM 0.x characters face backwards
    rest = np.array(tree["nodes"][node].get("rotation", (0.0, 0.0, 0.0, 1.0)))
    if not (np.linalg.norm(rotation, axis=0) > FLAT).all() or not np.linalg.norm(rest) > FLAT:
        raise RigError(f"{glb.source}: its head bone is scaled to nothing; export it again")
    return Bone(node, rest, _quaternion(rotation / np.linalg.norm(rotation, axis=0)))


def find_pivot(glb: Glb) -> tuple[Bone, Array] | None:
    """The bone of a head that looks along z, and where it turns, (3,) metres; none in VRM 0.x.

    Raises RigError.
    """
    bone = None if "VRM" in glb.tree.get("extensions", {}) else find_bone(glb)
    return None if bone is None else (bone, node_transform(glb, bone.node)[:3, 3])


def turning_share(glb: Glb, node: int, primitive: dict[str, Any], count: int, bone: Bone) -> Array:
    """How far each point of a node's primitive follows a bone and those below it, (count,) 0 to 1."""
    below = _below(glb, bone.node)
    entry = glb.tree["nodes"][node]
    if "skin" not in entry:
        return np.full(count, float(node in below))
    share = np.zeros(count)
    try:
        follows = np.array([joint in below for joint in glb.tree["skins"][entry["skin"]]["joints"]], float)
        for number in range(2):
            if f"JOINTS_{number}" in primitive["attributes"]:
                joints = glb.accessor(primitive["attributes"][f"JOINTS_{number}"]).astype(int)
                weights = glb.accessor(primitive["attributes"][f"WEIGHTS_{number}"])
                share += (follows[joints] * weights).sum(axis=1)
    except (RigError, *DAMAGE):
        return np.zeros(count)
    return share.clip(0, 1)


def _below(glb: Glb, node: int) -> set[int]:
    """A node and all below it."""
    found, waiting = set(), [node]
    while waiting:  # `check_tree` ensures that there is no cycle
        found.add(waiting[-1])
        waiting += glb.tree["nodes"][waiting.pop()].get("children", ())
    return found


def _humanoid_head(tree: dict[str, Any]) -> int | None:
    extensions = tree.get("extensions", {})
    for kind in ("VRMC_vrm", "VRMC_vrm_animation"):
        bones = extensions.get(kind, {}).get("humanoid", {}).get("humanBones", {})
        if "head" in bones:
            return int(bones["head"]["node"])
    listed = extensions.get("VRM", {}).get("humanoid", {}).get("humanBones", [])
    return next((int(bone["node"]) for bone in listed if bone.get("bone") == "head"), None)


def _quaternion(rotation: Array) -> Array:
    """A rotation matrix as (4,) xyzw (Bar-Itzhack 2000): the largest eigenvector of a symmetric matrix."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    form = np.array(
        [
            [a - e - i, b + d, c + g, h - f],
            [b + d, e - a - i, f + h, c - g],
            [c + g, f + h, i - a - e, d - b],
            [h - f, c - g, d - b, a + e + i],
        ]
    )
    found = np.linalg.eigh(form)[1][:, -1]
    return np.asarray(found * (1 if found[3] >= 0 else -1))
