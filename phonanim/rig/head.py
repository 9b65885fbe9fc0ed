"""The head: a mesh in six parts with morph targets, as in the shipped `head.glb`."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.lexicon import LEXICON
from phonanim.errors import RigError
from phonanim.media.glb import Glb, node_transform, read_glb
from phonanim.rig.morphs import has_targets, target_names
from phonanim.rig.names import match_shapes
from phonanim.rig.neck import Neck, find_bone

SHIPPED = LEXICON / "rigs" / "head.glb"
PARTS = ("skin", "tongue", "teeth_u", "teeth_l", "eye_l", "eye_r")
# Shapes of the shipped head that ARKit lacks. They move only its tongue, so no landmark shows them.
TONGUE = ("tongueBackUp", "tongueFrontUp", "tongueTipBack", "tongueTipForward", "tongueTipUp")


@dataclass(frozen=True)
class Head:
    """A head at rest and the motion of each control at full weight.

    `vertices` is (n, 3) metres, x to the character's left, y up, z forward; `triangles` (t, 3) indices;
    `parts` the rows of each part; `targets` the control names; `deltas` (targets, n, 3) metres;
    `colors` (n, 3) linear light reflected, 0 to 1; `neck` is where it turns, if known.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    parts: dict[str, slice]
    targets: tuple[str, ...]
    deltas: NDArray[np.float64]
    colors: NDArray[np.float64]
    neck: Neck | None = None

    def shape(self, weights: NDArray[Any]) -> NDArray[np.float64]:
        """Vertices under control weights, (..., targets) -> (..., n, 3) metres."""
        weights = np.asarray(weights, float)
        used = np.flatnonzero(weights.reshape(-1, len(self.targets)).any(axis=0))
        moved = weights[..., used] @ self.deltas.reshape(len(self.targets), -1)[used]
        return self.vertices + moved.reshape(*moved.shape[:-1], *self.vertices.shape)

    def without(self, names: Container[str]) -> Head:
        """The head without some of its shapes."""
        rows = [number for number, name in enumerate(self.targets) if name not in names]
        return replace(self, targets=tuple(self.targets[row] for row in rows), deltas=self.deltas[rows])

    def weights(self, values: NDArray[Any], channels: tuple[str, ...]) -> NDArray[np.float64]:
        """Curves by channel name as weights by target, (frames, channels) -> (frames, targets).

        Names match as in a character's file (phonanim/rig/names.py). Channels that the head lacks are left
        out; raises RigError when it has none of them.
        """
        moved = match_shapes(self.targets, channels, frozenset(self.targets), "the head")
        if not moved:
            raise RigError(
                f"the head has none of the channels {', '.join(channels[:4])} ...; use --rig arkit"
            )
        weights = np.zeros((len(values), len(self.targets)))
        for column, target, share in moved:
            weights[:, target] += share * np.asarray(values)[:, column]
        lessened = [target for _, target, share in moved if share < 0]
        weights[:, lessened] = np.maximum(weights[:, lessened], 0)
        return weights


def load_head(path: Path | None = None) -> Head:
    """Read a head: the shipped one, or a GLB with the same structure. Raises RigError."""
    return _shipped() if path is None else _head(read_glb(path))


@cache
def load_dressed_head() -> Head:
    """The shipped head with what it wears, which has no shapes, as more parts: the rows of the head first."""
    return _head(read_glb(SHIPPED), dressed=True)


@cache
def _shipped() -> Head:
    return _head(read_glb(SHIPPED))


def _head(glb: Glb, dressed: bool = False) -> Head:
    """The first mesh that has morph targets, its primitives joined, and those of meshes without any."""
    meshes = [mesh for mesh in glb.tree.get("meshes", []) if has_targets(mesh)]
    if not meshes:
        raise RigError(f"{glb.source}: has no morph targets; export the character with its shape keys")
    worn = [mesh for mesh in glb.tree["meshes"] if dressed and not has_targets(mesh)]
    primitives = [primitive for mesh in (meshes[0], *worn) for primitive in mesh["primitives"]]
    points = [point_rows(glb, primitive) for primitive in primitives]
    bounds = np.cumsum([0, *map(len, points)]).tolist()
    faces = [glb.faces(item, len(rows)) for item, rows in zip(primitives, points, strict=True)]
    spans = [slice(*span) for span in pairwise(bounds)]
    return Head(
        vertices=np.concatenate(points),
        triangles=np.concatenate([face + np.int64(at) for face, at in zip(faces, bounds, strict=False)]),
        parts=dict(zip(_part_names(glb, primitives), spans, strict=True)),
        targets=_target_names(glb, meshes[0]),
        deltas=_deltas(glb, primitives, spans),
        colors=np.concatenate([vertex_colors(glb, *item) for item in zip(primitives, points, strict=True)]),
        neck=_neck(glb, primitives),
    )


def _neck(glb: Glb, primitives: list[dict[str, Any]]) -> Neck | None:
    """Where the head turns, from the only skin of a file with the shipped head's structure."""
    bone = find_bone(glb)
    if bone is None or not all("WEIGHTS_0" in primitive["attributes"] for primitive in primitives):
        return None
    joints_of_skin = glb.tree.get("skins", [{"joints": []}])[0]["joints"]
    if bone.node not in joints_of_skin or not all("JOINTS_0" in item["attributes"] for item in primitives):
        return None
    joint = joints_of_skin.index(bone.node)
    shares = []
    for primitive in primitives:
        joints = glb.accessor(primitive["attributes"]["JOINTS_0"])
        weights = glb.accessor(primitive["attributes"]["WEIGHTS_0"])
        if joints.shape != weights.shape or len(joints) != len(point_rows(glb, primitive)):
            raise RigError(f"{glb.source}: its skin weights do not fit its points; export it again")
        shares.append(np.where(joints == joint, weights, 0.0).sum(axis=1))
    return Neck(node_transform(glb, bone.node)[:3, 3], np.concatenate(shares).astype(float))


def _target_names(glb: Glb, mesh: dict[str, Any]) -> tuple[str, ...]:
    names = target_names(mesh, glb.tree.get("accessors", []))
    if not all(names):
        raise RigError(f"{glb.source}: its morph targets have no names (mesh extras.targetNames); name them")
    return names


def _part_names(glb: Glb, primitives: list[dict[str, Any]]) -> list[str]:
    materials = glb.tree.get("materials", [])
    names = [materials[p["material"]].get("name", "") if "material" in p else "" for p in primitives]
    return [name if name and names.count(name) == 1 else f"part{i}" for i, name in enumerate(names)]


def _deltas(glb: Glb, primitives: list[dict[str, Any]], spans: list[slice]) -> NDArray[np.float64]:
    """(targets, n, 3) metres."""
    deltas = np.zeros((len(primitives[0]["targets"]), spans[-1].stop, 3))
    for primitive, span in zip(primitives, spans, strict=True):
        for target, delta in zip(primitive.get("targets", ()), deltas, strict=False):
            if "POSITION" in target:
                delta[span] = glb.positions(target["POSITION"], len(delta[span]))
    return deltas


def vertex_colors(glb: Glb, primitive: dict[str, Any], points: NDArray[Any]) -> NDArray[np.float64]:
    """(n, 3) linear: the material's colour times the vertex colours."""
    material = glb.tree["materials"][primitive["material"]] if "material" in primitive else {}
    factor = material.get("pbrMetallicRoughness", {}).get("baseColorFactor", (0.8, 0.8, 0.8, 1.0))
    colors = np.tile(np.asarray(factor[:3], float), (len(points), 1))
    if "COLOR_0" in primitive["attributes"]:
        shades = glb.accessor(primitive["attributes"]["COLOR_0"])[:, :3]
        if shades.shape != colors.shape or not np.isfinite(shades).all():
            raise RigError(f"{glb.source}: its vertex colours do not fit its points; export it again")
        colors *= shades
    return colors


def point_rows(glb: Glb, primitive: dict[str, Any]) -> NDArray[np.float64]:
    """The points of a primitive, (n, 3) metres. Raises RigError where it has none."""
    if "POSITION" not in primitive["attributes"]:
        raise RigError(f"{glb.source}: holds a mesh without positions; export it again")
    return glb.positions(primitive["attributes"]["POSITION"])
