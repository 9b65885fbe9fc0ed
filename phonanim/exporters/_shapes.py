"""Curves of blend shapes under the paths of their meshes, for game engines."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.animation.keys import reduce_curve
from phonanim.media.glb import Glb, read_glb
from phonanim.rig.head import SHIPPED
from phonanim.rig.morphs import moving_morphs
from phonanim.rig.neck import is_turn

KEYS = 0.002
"""Error of keys, of full weight, unless another is asked for: a key at every frame makes texts of many MB."""


@dataclass(frozen=True)
class ShapeCurve:
    """The weights of one shape: the path of its mesh, the shape's name, `curve` (frames,)."""

    node: str
    shape: str
    curve: NDArray[np.float64]


def shape_curves(animation: Animation, node: str | None, character: Path | None) -> list[ShapeCurve]:
    """A curve for each shape that the animation moves.

    With a `character`, a GLB or VRM, its meshes and the names of its shapes; else those of the channels.
    `node` is the path of the one mesh; without it, paths are those in the character. Raises RigError when the
    character cannot be read or has no such shape.
    """
    if character is None:
        place = node or _path(read_glb(SHIPPED), 0)
        names = [name for name in animation.channels if not is_turn(name)]
        return [ShapeCurve(place, name, animation.channel(name).astype(float)) for name in names]
    glb = read_glb(character)
    found: dict[tuple[str, str], ShapeCurve] = {}
    for morphs in moving_morphs(glb, animation.channels):
        weights = morphs.weights(animation.values, animation.channels)
        for target in sorted({target for _, target, _ in morphs.moved(animation.channels)}):
            one = ShapeCurve(node or _path(glb, morphs.node), morphs.names[target], weights[:, target])
            if one.shape:
                found.setdefault((one.node, one.shape), one)
    return list(found.values())


def curve_keys(
    animation: Animation, curve: NDArray[np.float64], keys: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times, (k,) seconds, none below zero, and values, (k,), of keys within this error."""
    times = animation.times - min(0.0, animation.start)
    reduced = reduce_curve(curve, keys)
    return times[reduced.frames], reduced.values[:, 0]


def _path(glb: Glb, node: int) -> str:
    """The names of a node and of those above it, from the top."""
    names = [_name(glb, node)]
    while node in glb.parents:
        node = glb.parents[node]
        names.insert(0, _name(glb, node))
    return "/".join(names)


def _name(glb: Glb, node: int) -> str:
    return str(glb.tree["nodes"][node].get("name", f"node{node}"))
