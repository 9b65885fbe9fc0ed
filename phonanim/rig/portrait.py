"""A character for pictures: all meshes around its face, with their textures, turned to the viewer."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import RigError
from phonanim.rig.character import load_dressed_character
from phonanim.rig.head import Head
from phonanim.rig.names import match_shapes
from phonanim.rig.neck import Neck
from phonanim.rig.render import View

Array = NDArray[np.float64]

LIDS = re.compile(r"blink|eyes?_?clos|まばたき", re.IGNORECASE)
MUCH = 0.2  # of a shape's largest motion: what moves less is not its place
AROUND, ALONE = 1.7, 3.4  # of the height of what moves, with the eyes and without
NEAR = 3.0  # heights of the face: what is farther away is not drawn
FACE = 0.12  # metres between brows and chin: faces of other sizes are scaled to it
RAISED = 0.5  # of the height of a mouth: the middle of its face


@dataclass(frozen=True)
class Portrait:
    """A head to draw, and the view of its face."""

    head: Head
    view: View


def load_portrait(path: Path, channels: tuple[str, ...], height: int, width: int, yaw: float) -> Portrait:
    """A GLB or VRM character that channels move, framed on its face.

    Raises RigError when the file cannot be read or has a shape for none of the channels.
    """
    head = load_dressed_character(path)
    moved = sorted(
        {row for _, row, _ in match_shapes(head.targets, channels, frozenset(head.targets), str(path))}
    )
    if not moved:
        raise RigError(
            f"{path}: has no morph target named like {', '.join(channels[:3])} ...; choose another --rig, "
            "or give their names as --names"
        )
    lids = [row for row, name in enumerate(head.targets) if LIDS.search(name)]
    low, high = _reach(head, [*moved, *lids])
    tall, middle = float(high[1] - low[1]), (low + high) / 2
    head = _cropped(head, middle, NEAR * tall)
    head, middle = _facing(head, middle, tall)
    scale = FACE / max(tall, 1e-9) * (1.0 if lids else 0.5)
    neck = None if head.neck is None else replace(head.neck, pivot=head.neck.pivot * scale)
    head = replace(head, vertices=head.vertices * scale, deltas=head.deltas * scale, neck=neck)
    middle, tall = middle * scale, tall * scale
    middle[1] += 0 if lids else RAISED * tall
    front = float(head.vertices[np.abs(head.vertices[:, 1] - middle[1]) < tall, 2].max(initial=-np.inf))
    centre = (float(middle[0]), float(middle[1]), min(float(middle[2]), front))
    return Portrait(head, View(centre, (AROUND if lids else ALONE) * tall, height, width, yaw))


def _reach(head: Head, rows: list[int]) -> tuple[Array, Array]:
    """The corners of the box around what shapes move."""
    seen = np.zeros(len(head.vertices), bool)
    for row in rows:
        lengths = np.linalg.norm(head.deltas[row], axis=1)
        seen |= (lengths >= MUCH * lengths.max()) & (lengths > 0)
    if not seen.any():
        raise RigError("the shapes of the character move nothing; export it with its shape keys")
    return head.vertices[seen].min(axis=0), head.vertices[seen].max(axis=0)


def _cropped(head: Head, middle: Array, reach: float) -> Head:
    """The triangles within a distance of a place."""
    near = np.linalg.norm(head.vertices - middle, axis=1) < reach
    faces = head.triangles[near[head.triangles].all(axis=1)]
    rows = np.unique(faces)
    places = np.zeros(len(near), np.int64)
    places[rows] = np.arange(len(rows))
    return Head(
        vertices=head.vertices[rows],
        triangles=places[faces],
        parts={"character": slice(0, len(rows))},
        targets=head.targets,
        deltas=head.deltas[:, rows],
        colors=head.colors[rows],
        neck=None if head.neck is None else Neck(head.neck.pivot, head.neck.share[rows]),
    )


def _facing(head: Head, face: Array, tall: float) -> tuple[Head, Array]:
    """The head and its face, a place, turned by quarters until it is in front of the middle of the head."""
    level = head.vertices[np.abs(head.vertices[:, 1] - face[1]) < tall / 2]
    if not len(level):
        raise RigError("the shapes of the character move nothing that has a height; export the head whole")
    ahead = face - (level.min(axis=0) + level.max(axis=0)) / 2
    quarter = round(float(np.arctan2(ahead[0], ahead[2])) / (np.pi / 2))
    sine, cosine = (0, -1, 0, 1)[quarter % 4], (1, 0, -1, 0)[quarter % 4]
    turn = np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]], float)
    neck = None if head.neck is None else replace(head.neck, pivot=turn @ head.neck.pivot)
    moved = replace(head, vertices=head.vertices @ turn.T, deltas=head.deltas @ turn.T, neck=neck)
    return moved, turn @ face
