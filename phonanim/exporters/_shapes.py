"""Curves of blend shapes under the paths of their meshes, for game engines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.animation.keys import reduce_curve, reduce_curves
from phonanim.media.glb import Glb, kept_glb
from phonanim.rig.head import SHIPPED
from phonanim.rig.morphs import moving_morphs
from phonanim.rig.neck import find_bone, is_turn, turns_of

KEYS = 0.002
"""Error of keys, of full weight, unless another is asked for: a key at every frame makes texts of many MB."""

TURN_ERROR = 0.1  # of the error of keys, for rotations: 0.0002 of a quaternion is a fortieth of a degree


@dataclass(frozen=True)
class ShapeCurve:
    """The weights of one shape: the path of its mesh, the shape's name, `curve` (frames,)."""

    node: str
    shape: str
    curve: NDArray[np.float64]


def node_path(glb: Glb, node: int) -> str:
    """The names of a node and of those above it, from the top."""
    names = [_name(glb, node)]
    while node in glb.parents:
        node = glb.parents[node]
        names.insert(0, _name(glb, node))
    return "/".join(names)


def shape_curves(
    animation: Animation,
    node: str | None,
    character: Path | None,
    path_of: Callable[[Glb, int], str] = node_path,
) -> list[ShapeCurve]:
    """A curve for each shape that the animation moves.

    With a `character`, a GLB or VRM, its meshes and the names of its shapes; else those of the channels.
    `node` is the path of the one mesh; without it, `path_of` finds that of a node of the character, or of the
    shipped head. Raises RigError when the character cannot be read or has no such shape.
    """
    if character is None:
        place = node or path_of(kept_glb(SHIPPED), 0)
        names = [name for name in animation.channels if not is_turn(name)]
        return [ShapeCurve(place, name, animation.channel(name).astype(float)) for name in names]
    glb = kept_glb(character)
    found: dict[tuple[str, str], ShapeCurve] = {}
    for morphs in moving_morphs(glb, animation.channels):
        weights = morphs.weights(animation.values, animation.channels)
        for target in sorted({target for _, target, _ in morphs.moved(animation.channels)}):
            one = ShapeCurve(node or path_of(glb, morphs.node), morphs.names[target], weights[:, target])
            if one.shape:
                found.setdefault((one.node, one.shape), one)
    return list(found.values())


@dataclass(frozen=True)
class HeadTurn:
    """The rotations of the bone of a head, (frames, 4) xyzw, each on the same side as the one before.

    `glb` is the character, `node` the number of the bone's node there. The rotations are the node's own, in
    glTF's axes.
    """

    glb: Glb
    node: int
    rotations: NDArray[np.float64]

    def keys(self, animation: Animation, keys: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Times, (k,) seconds, none below zero, and rotations, (k, 4), of keys within this error."""
        times = animation.times - min(0.0, animation.start)
        reduced = reduce_curves(self.rotations, keys * TURN_ERROR)
        return times[reduced.frames], reduced.values


def head_turn(animation: Animation, character: Path | None) -> HeadTurn | None:
    """How the head of a character turns; none where it does not, or has no bone. Raises RigError."""
    turns = turns_of(animation.values, animation.channels)
    if character is None or turns is None:
        return None
    glb = kept_glb(character)
    bone = find_bone(glb)
    if bone is None:
        return None
    rotations = bone.rotations(turns)
    sides = np.sign((rotations[1:] * rotations[:-1]).sum(axis=1))
    rotations[1:] *= np.cumprod(np.where(sides == 0, 1.0, sides))[:, None]
    return HeadTurn(glb, bone.node, rotations)


def curve_keys(
    animation: Animation, curve: NDArray[np.float64], keys: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times, (k,) seconds, none below zero, and values, (k,), of keys within this error."""
    times = animation.times - min(0.0, animation.start)
    reduced = reduce_curve(curve, keys)
    return times[reduced.frames], reduced.values[:, 0]


def _name(glb: Glb, node: int) -> str:
    return str(glb.tree["nodes"][node].get("name", f"node{node}"))
