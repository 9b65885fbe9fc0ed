"""A character's file as a head to fit: every mesh that has morph targets, and which of them are speech."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import RigError
from phonanim.face.model import OUTER_LIPS, FaceModel, lip_aperture, lip_protrusion, lip_width
from phonanim.media.glb import Glb, read_glb, world
from phonanim.metrics import correlation
from phonanim.rig.fit import fit_rig
from phonanim.rig.head import TONGUE, Head, load_head, reflected
from phonanim.rig.landmarks import MeshLandmarks, shipped_landmarks
from phonanim.rig.meshes import read_obj
from phonanim.rig.morphs import Morphs, find_morphs, plain
from phonanim.rig.motion import read_motion
from phonanim.rig.puppet import Puppet, control_partners, make_puppet
from phonanim.rig.read import load_rig
from phonanim.rig.register import suggest_landmarks
from phonanim.rig.retarget import retarget
from phonanim.rig.rig import Rig

Array = NDArray[np.float64]

GREY = 0.3  # what the parts of a character reflect in pictures, where the file itself does not tell
# Shapes that move the lips but say nothing.
MOODS = frozenset({"happy", "angry", "sad", "relaxed", "surprised", "joy", "sorrow", "fun", "cheekpuff"})
LEAST_MOTION = 1.0  # mm of some lip point: less is no shape of speech
CANCELLING = 0.5  # of the two sides' motion: less is left where they pull against each other
ENOUGH_ARKIT = 10  # speech controls with ARKit's names: then these are the character's


def load_character(path: Path) -> Head:
    """Read a GLB or VRM file: all meshes with morph targets end to end, targets of one name as one.

    VRM expressions stand in place of the targets that they group. Raises RigError.
    """
    glb = read_glb(path)
    return _joined([piece for morphs in find_morphs(glb) for piece in _pieces(glb, morphs)], path)


def load_mesh(path: Path) -> Head:
    """Read a head without shapes, from an OBJ file or all meshes of a GLB file. Raises RigError."""
    if path.suffix.lower() == ".obj":
        points, triangles, parts = read_obj(path)
        return Head(points, triangles, parts, (), np.zeros((0, *points.shape)), np.full_like(points, GREY))
    glb = read_glb(path)
    nodes = [number for number, node in enumerate(glb.tree.get("nodes", [])) if "mesh" in node]
    if not nodes:
        raise RigError(f"{path}: holds no mesh; export the head")
    return _joined([piece for node in nodes for piece in _pieces(glb, Morphs(str(path), node, ()))], path)


def _joined(pieces: list[Piece], path: Path) -> Head:
    """Pieces end to end as one head."""
    names = tuple(dict.fromkeys(name for piece in pieces for name in piece.controls))
    bounds = np.cumsum([0, *(len(piece.points) for piece in pieces)]).tolist()
    spans = [slice(*span) for span in pairwise(bounds)]
    deltas = np.zeros((len(names), bounds[-1], 3))
    for piece, span in zip(pieces, spans, strict=True):
        for name, mixture in piece.controls.items():
            deltas[names.index(name), span] = np.tensordot(mixture, piece.moves, axes=1)
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
    )


@dataclass(frozen=True)
class Piece:
    """One primitive in the world's axes: points (n, 3), faces (t, 3), moves of its targets (targets, n, 3).

    `controls` are the weights of the targets (targets,) by the name that moves them; `colors` (n, 3) are what
    it reflects.
    """

    name: str
    points: Array
    faces: NDArray[np.int64]
    moves: Array
    controls: dict[str, Array]
    colors: Array


def _controls(morphs: Morphs) -> dict[str, Array]:
    """What moves a node's targets, by name: weights of each (targets,)."""
    unit = np.eye(len(morphs.names))
    mixed = {
        name: np.sum([unit[target] * weight for target, weight in pairs], axis=0)
        for name, pairs in morphs.binds.items()
        if pairs
    }
    return mixed or {name: unit[number] for number, name in enumerate(morphs.names) if name}


def _pieces(glb: Glb, morphs: Morphs) -> list[Piece]:
    """The primitives of a node's mesh, named by node and material."""
    node = glb.tree["nodes"][morphs.node]
    matrix, controls = world(glb.tree, morphs.node), _controls(morphs)
    turn = matrix[:3, :3].T
    pieces = []
    for primitive in glb.tree["meshes"][node["mesh"]]["primitives"]:
        points = glb.accessor(primitive["attributes"]["POSITION"]).astype(np.float64)
        index = glb.accessor(primitive["indices"]) if "indices" in primitive else np.arange(len(points))
        material = glb.tree["materials"][primitive["material"]] if "material" in primitive else {}
        name = f"{node.get('name', 'node')}.{material.get('name', '')}"
        named = primitive.get("targets", ()) if controls else ()
        moves = np.array([_moved(glb, target, len(points)) for target in named]).reshape(-1, *points.shape)
        faces = index.reshape(-1, 3).astype(np.int64)
        told = _tells_colour(material, primitive)
        colors = reflected(glb, primitive, points) if told else np.full_like(points, GREY)
        placed = points @ turn + matrix[:3, 3]
        pieces.append(Piece(name, placed, faces, moves @ turn, controls, colors))
    return pieces


def _tells_colour(material: dict[str, Any], primitive: dict[str, Any]) -> bool:
    """Whether colours stand in the file itself: not in a picture, and not left to the viewer."""
    surface = material.get("pbrMetallicRoughness", {})
    return "baseColorTexture" not in surface and (
        "baseColorFactor" in surface or "COLOR_0" in primitive["attributes"]
    )


def _moved(glb: Glb, target: dict[str, int], count: int) -> Array:
    return (
        glb.accessor(target["POSITION"]).astype(np.float64) if "POSITION" in target else np.zeros((count, 3))
    )


def fit_character(
    head: Head, face: FaceModel, name: str, spots: MeshLandmarks | None = None
) -> tuple[Rig, MeshLandmarks]:
    """A rig for a head with blendshapes, and where the landmarks lie on it (suggested when not given).

    Raises RigError when the face cannot be found or no shape moves the lips.
    """
    arkit, head = load_rig("arkit"), head.without(TONGUE)
    if spots is None:
        spots = suggest_landmarks(load_head(), shipped_landmarks(), head)
    puppet = make_puppet(head, spots, face)
    rig = blank(head, name, speech_controls(puppet, face, arkit))
    return fit_rig(rig, puppet, face, read_motion().modes(face)), spots


def blank(head: Head, name: str, speech: tuple[str, ...]) -> Rig:
    """A head's shapes as controls from 0 to 1, not yet fitted."""
    zeros, ones = np.zeros(len(head.targets)), np.ones(len(head.targets))
    places = {plain(target): number for number, target in enumerate(head.targets)}
    rig = Rig(
        name, f"{name}, fitted", "phonanim rig fit", head.targets, zeros, ones, zeros, zeros, zeros[None][:0]
    )
    if "mouthclose" in places and "jawopen" in places:
        rig = replace(rig, at_most=((places["mouthclose"], places["jawopen"]),))
    return replace(rig, speech=speech)


def speech_controls(puppet: Puppet, face: FaceModel, arkit: Rig) -> tuple[str, ...]:
    """The controls that speech moves: ARKit's by name, else all that move the lips and are no mood.

    Pairs that pull the mouth to either side cancel each other and are left out. Raises RigError when
    nothing is left.
    """
    known = {plain(name) for name in arkit.speech}
    named = tuple(name for name in puppet.controls if plain(name) in known)
    if len(named) >= ENOUGH_ARKIT:
        return named
    lips = puppet.shapes[:, face.rows(OUTER_LIPS)]
    both = lips + lips[control_partners(puppet)]
    size = np.linalg.norm(lips, axis=(1, 2))
    moving = np.linalg.norm(lips, axis=2).max(axis=1) > LEAST_MOTION
    apart = np.linalg.norm(both, axis=(1, 2)) < CANCELLING * 2 * size
    chosen = tuple(
        name
        for name, speaks in zip(puppet.controls, moving & ~apart, strict=True)
        if speaks and plain(name) not in MOODS
    )
    if not chosen:
        raise RigError("no shape of the head moves its lips; check its morph targets, or give --landmarks")
    return chosen


def quality(rig: Rig, head: Head, spots: MeshLandmarks, face: FaceModel) -> dict[str, float]:
    """How well the lips of a fitted head follow the face on the motion sample: correlations by measure."""
    modes = read_motion().modes(face)
    posed = make_puppet(head, spots, face).pose(retarget(modes, face, rig))
    shapes = face.instance(modes)
    measures = {"aperture": lip_aperture, "width": lip_width, "protrusion": lip_protrusion}
    return {name: round(correlation(of(posed, face), of(shapes, face)), 4) for name, of in measures.items()}
