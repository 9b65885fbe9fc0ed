"""Where a skeleton at rest puts the points of a skinned mesh (glTF 2.0, section 3.7.3)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE
from phonanim.errors import RigError
from phonanim.media.glb import Glb, node_transform

Array = NDArray[np.float64]

SAME = 1e-4  # elements of matrices that differ less are alike


def placement(glb: Glb, node: int, primitive: dict[str, Any], count: int) -> Array:
    """The transform of the points of a node's primitive: (4, 4), or (count, 4, 4) where they differ.

    A mesh without a skin is placed by its node, one with a skin by the joints alone. The joints are taken as
    the file leaves them. Programs that pack positions as integers unpack them in the joints. A skin that is
    damaged places nothing.
    """
    skin = glb.tree["nodes"][node].get("skin")
    if skin is None:
        return node_transform(glb, node)
    try:
        moves = _joint_moves(glb, glb.tree["skins"][skin])
        if np.abs(moves - moves[0]).max() < SAME:
            return np.eye(4) if np.abs(moves[0] - np.eye(4)).max() < SAME else moves[0]
        return _blended(glb, primitive, moves, count)
    except (RigError, *DAMAGE):
        return np.eye(4)


def moved_points(points: Array, matrix: Array) -> Array:
    """Points under a placement, (n, 3) -> (n, 3)."""
    return np.asarray(turned(points, matrix) + matrix[..., :3, 3])


def turned(offsets: Array, matrix: Array) -> Array:
    """Offsets under a placement, (..., n, 3) -> the same shape."""
    if matrix.ndim == 2:
        return np.asarray(offsets @ matrix[:3, :3].T)
    return np.einsum("nij,...nj->...ni", matrix[:, :3, :3], offsets)


def _joint_moves(glb: Glb, skin: dict[str, Any]) -> Array:
    """What each joint does to points at rest, (joints, 4, 4)."""
    joints = np.array([node_transform(glb, joint) for joint in skin["joints"]])
    if "inverseBindMatrices" not in skin:
        return joints
    back = glb.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    moves = joints @ back[: len(joints)].astype(float)
    if not np.isfinite(moves).all():
        raise RigError(f"{glb.source}: its joints are not finite; export it again")
    return np.asarray(moves)


def _blended(glb: Glb, primitive: dict[str, Any], moves: Array, count: int) -> Array:
    """The joints' moves mixed for each point, (count, 4, 4)."""
    sums, total = np.zeros((count, 4, 4)), np.zeros(count)
    for number in range(2):
        if f"JOINTS_{number}" not in primitive["attributes"]:
            break
        joints = glb.accessor(primitive["attributes"][f"JOINTS_{number}"])
        weights = glb.accessor(primitive["attributes"][f"WEIGHTS_{number}"]).astype(float)
        for joint, weight in zip(joints.T, weights.T, strict=True):
            sums += weight[:, None, None] * moves[joint.astype(int)]
            total += weight
    loose = np.abs(total) < SAME
    sums[loose] = np.eye(4)
    return np.asarray(sums / np.where(loose, 1.0, total)[:, None, None])
