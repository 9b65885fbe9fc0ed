"""Read a character's file as a head: all meshes that have morph targets."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError
from phonanim.errors import RigError
from phonanim.media.glb import Glb, read_glb
from phonanim.media.gltf import WORTH, check_room
from phonanim.media.skinning import moved_points, placement, turned
from phonanim.rig.head import Head, point_rows, vertex_colors
from phonanim.rig.morphs import Morphs, find_morphs
from phonanim.rig.neck import Bone, Neck, find_pivot, turning_share
from phonanim.rig.textures import seen_faces, texture_colors

Array = NDArray[np.float64]

GREY = 0.3  # reflectance of a character's parts in pictures, where the file does not define it


def load_character(path: Path) -> Head:
    """Read a GLB or VRM file: all meshes with morph targets joined, targets with the same name merged.

    VRM expressions replace the targets that they group; empty ones are left out. Raises RigError.
    """
    glb = read_glb(path)
    return _joined(_all_pieces(glb, find_morphs(glb)), path, glb)


def load_painted_character(path: Path) -> Head:
    """Read a character as `load_character` does, point by point, with the colours of its textures.

    What is clear in the textures has no triangles. Raises RigError.
    """
    glb = read_glb(path)
    moving = find_morphs(glb)
    return _joined(_all_pieces(glb, moving, textured=True), path, glb)


def load_dressed_character(path: Path) -> Head:
    """Read a character with its hair and clothes, which have no shapes, and its textures. Raises RigError."""
    glb = read_glb(path)
    moving = find_morphs(glb)
    known = {morphs.node for morphs in moving}
    nodes = [
        number for number, node in enumerate(glb.tree["nodes"]) if "mesh" in node and number not in known
    ]
    bare = [Morphs(str(path), number, ()) for number in nodes]
    return _joined(_all_pieces(glb, [*moving, *bare], textured=True), path, glb)


def load_bare_character(path: Path) -> Head:
    """Read all meshes of a GLB file, joined, without their shapes. Raises RigError."""
    glb = read_glb(path)
    nodes = [number for number, node in enumerate(glb.tree.get("nodes", [])) if "mesh" in node]
    if not nodes:
        raise RigError(f"{path}: holds no mesh; export the head")
    return _joined(_all_pieces(glb, [Morphs(str(path), node, ()) for node in nodes]), path)


def _all_pieces(glb: Glb, groups: list[Morphs], textured: bool = False) -> list[Piece]:
    """The pieces of several nodes, with their shares of the turn of the head."""
    found = find_pivot(glb)
    bone = None if found is None else found[0]
    return [piece for morphs in groups for piece in _pieces(glb, morphs, bone, textured)]


def _joined(pieces: list[Piece], path: Path, glb: Glb | None = None) -> Head:
    """Join pieces into one head, which turns where the skeleton of its file `glb` lets it."""
    names = tuple(dict.fromkeys(name for piece in pieces for name in piece.controls))
    bounds = np.cumsum([0, *(len(piece.points) for piece in pieces)]).tolist()
    spans = [slice(*span) for span in pairwise(bounds)]
    try:
        check_room(len(names) * bounds[-1] * 3 * WORTH, path.stat().st_size)
    except DecodeError as error:
        raise RigError(f"{path}: is damaged: {error}; export it again") from error
    deltas = np.zeros((len(names), bounds[-1], 3))
    places = {name: number for number, name in enumerate(names)}
    for piece, span in zip(pieces, spans, strict=True):
        for name, mixture in piece.controls.items():
            deltas[places[name], span] = np.tensordot(mixture, piece.moves, axes=1)
    vertices = np.concatenate([piece.points for piece in pieces])
    if not (np.isfinite(vertices).all() and np.isfinite(deltas).all()):
        raise RigError(f"{path}: holds positions that are not finite; export it again")
    return Head(
        vertices=vertices,
        triangles=np.concatenate([p.faces + at for p, at in zip(pieces, bounds, strict=False)]),
        parts={f"{piece.name}.{i}": span for i, (piece, span) in enumerate(zip(pieces, spans, strict=True))},
        targets=names,
        deltas=deltas,
        colors=np.concatenate([piece.colors for piece in pieces]),
        neck=_neck(glb, np.concatenate([piece.share for piece in pieces])),
    )


def _neck(glb: Glb | None, share: Array) -> Neck | None:
    found = None if glb is None else find_pivot(glb)
    return None if found is None or not share.any() else Neck(found[1], share)


@dataclass(frozen=True)
class Piece:
    """One primitive in the world's axes: points (n, 3), faces (t, 3), moves of its targets (targets, n, 3).

    `controls` maps each control name to its weights of the targets (targets,); `colors` (n, 3) are its
    reflectance, and `share` (n,) is how far they turn with the head.
    """

    name: str
    points: Array
    faces: NDArray[np.int64]
    moves: Array
    controls: dict[str, Array]
    colors: Array
    share: Array


def _controls(morphs: Morphs) -> dict[str, Array]:
    """The controls of a node's targets: weights (targets,) by name."""
    unit = np.eye(len(morphs.names))
    mixed = {
        name: np.sum([unit[target] * weight for target, weight in pairs], axis=0)
        for name, pairs in morphs.binds.items()
        if pairs
    }
    present = morphs.names if morphs.present is None else morphs.present
    return mixed or {
        name: unit[number] for number, name in enumerate(morphs.names) if name and name in present
    }


def _pieces(glb: Glb, morphs: Morphs, bone: Bone | None, textured: bool) -> list[Piece]:
    """The primitives of a node's mesh, named by node and material, and `textured` where they can be."""
    node = glb.tree["nodes"][morphs.node]
    controls = _controls(morphs)
    pieces = []
    for primitive in glb.tree["meshes"][node["mesh"]]["primitives"]:
        points = point_rows(glb, primitive)
        material = glb.tree["materials"][primitive["material"]] if "material" in primitive else {}
        name = f"{node.get('name', 'node')}.{material.get('name', '')}"
        named = primitive.get("targets", ()) if controls else ()
        moves = np.array([_moved(glb, target, len(points)) for target in named]).reshape(-1, *points.shape)
        faces = glb.faces(primitive, len(points))
        if textured:
            faces = faces[seen_faces(glb, primitive, faces, len(points))]
        coloured = _tells_colour(material, primitive)
        colors = vertex_colors(glb, primitive, points) if coloured else np.full_like(points, GREY)
        texture = texture_colors(glb, primitive, len(points)) if textured else None
        colors = colors if texture is None else texture
        matrix = placement(glb, morphs.node, primitive, len(points))
        placed = moved_points(points, matrix)
        share = np.zeros(len(points))
        if bone is not None:
            share = turning_share(glb, morphs.node, primitive, len(points), bone)
        pieces.append(Piece(name, placed, faces, turned(moves, matrix), controls, colors, share))
    return pieces


def _tells_colour(material: dict[str, Any], primitive: dict[str, Any]) -> bool:
    """Whether the file itself holds colours, not a texture image or the viewer's default."""
    surface = material.get("pbrMetallicRoughness", {})
    return "baseColorTexture" not in surface and (
        "baseColorFactor" in surface or "COLOR_0" in primitive["attributes"]
    )


def _moved(glb: Glb, target: dict[str, int], count: int) -> Array:
    return glb.positions(target["POSITION"], count) if "POSITION" in target else np.zeros((count, 3))
