"""Motion as a surface in millimetres, with its regions and its lip curves.

Controls of ARKit move the package's head. Vertices are a mesh that is recognized by its number of vertices:
the package's head, MediaPipe's face mesh, the reference face, or a mesh of the user with the user's masks.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.catalog import DEFAULT_MODEL, find_model
from phonanim.errors import EvaluationError
from phonanim.evaluation.predictions import Motion, Vertices
from phonanim.face.masks import check_masks, head_masks, landmark_numbers
from phonanim.face.model import UPPER_LIP_INNER, FaceModel, lip_aperture, lip_protrusion, lip_width
from phonanim.regressors import load_face
from phonanim.rig.head import load_head
from phonanim.rig.landmarks import MeshLandmarks, shipped_landmarks
from phonanim.rig.morphs import plain_name
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
UNITS = {"m": 1000.0, "cm": 10.0, "mm": 1.0}
LARGEST = {"m": 3.0, "cm": 60.0}  # of a head and its shoulders, in that unit
OWN_SHARE = 0.25  # of controls whose names are those of the package's head, for controls that are its own
FACE_MESH = 478  # points of MediaPipe's face mesh with irises


@dataclass(frozen=True)
class Settings:
    """Facts about the files that they do not contain.

    `masks` are rows by region, `lips` four vertices (upper and lower lip, right and left corner), the
    templates are meshes at rest (vertices, 3), `unit` is that of coordinates (detected by size when None),
    `track` has the phones.
    """

    masks: Mapping[str, Rows] = field(default_factory=dict)
    lips: tuple[int, ...] = ()
    template: Array | None = None
    reference_template: Array | None = None
    unit: str | None = None
    track: PhoneTrack | None = None


@dataclass(frozen=True)
class Surface:
    """A moving mesh: `points` (frames, vertices, 3) mm, `rest` (vertices, 3) mm or None, rows by region.

    `lips` are curves (frames,) in mm: aperture, width, and protrusion and upper_lip (its height) if the axes
    are known; empty if the lips are unknown.
    """

    points: Array
    rest: Array | None
    masks: Mapping[str, Rows]
    lips: Mapping[str, Array]
    notes: tuple[str, ...] = ()


def moves_head(animation: Animation) -> bool:
    """Whether controls are those of the package's head: at least a quarter have names of its shapes.

    A few names in common with another rig are chance.
    """
    shapes = set(map(plain_name, load_head().targets))
    named = sum(plain_name(name) in shapes for name in animation.channels)
    return named > 0 and named >= OWN_SHARE * len(animation.channels)


def make_surface(motion: Motion, settings: Settings, template: Array | None = None) -> Surface | None:
    """The surface that a side moves; None for controls that the package's head does not have.

    The package's head is reduced to the vertices of its regions. Raises EvaluationError when a mask, the lips
    or the template do not match the mesh.
    """
    if isinstance(motion, Animation):
        return _on_head(motion, settings)
    vertices = motion.points.shape[1]
    if template is not None and len(template) != vertices:
        raise EvaluationError(
            f"the template has shape {template.shape}, a frame {motion.points.shape[1:]}; they must be equal"
        )
    scale, notes = _scale(motion, settings.unit)
    points, rest = motion.points * scale, None if template is None else template * scale
    if vertices == len(load_head().vertices):
        return _cut(points, 1000 * load_head().vertices if rest is None else rest, settings, notes)
    masks, spots = _known(vertices)
    lips = landmark_lips(points, spots.numbers) if spots else {}
    lips = _own_lips(points, settings.lips) if settings.lips else lips
    return Surface(points, rest, check_masks({**masks, **settings.masks}, vertices), lips, notes)


def _on_head(animation: Animation, settings: Settings) -> Surface | None:
    """The package's head, moved by curves with the names of its shapes."""
    head, spots = load_head(), shipped_landmarks()
    named = {plain_name(target): target for target in head.targets}
    channels = tuple(named.get(plain_name(name), name) for name in animation.channels)
    if not moves_head(animation):
        return None
    weights = head.weights(animation.values, channels)
    used, masks = _head_regions(settings)
    landmarks = spots.of(head.vertices) + np.tensordot(weights, spots.of(head.deltas), axes=1)
    rest, deltas = 1000 * head.vertices[used], 1000 * head.deltas[:, used]
    points = rest + np.tensordot(weights, deltas, axes=1)
    return Surface(points, rest, masks, landmark_lips(1000 * landmarks, spots.numbers))


def _cut(points: Array, rest: Array, settings: Settings, notes: tuple[str, ...]) -> Surface:
    """All vertices of the package's head, (frames, vertices, 3) mm, reduced as `_on_head` does."""
    used, masks = _head_regions(settings)
    spots = shipped_landmarks()
    return Surface(points[:, used], rest[used], masks, landmark_lips(spots.of(points), spots.numbers), notes)


def _head_regions(settings: Settings) -> tuple[Rows, dict[str, Rows]]:
    """The vertices of the package's head that are in a region, and the regions as rows of those."""
    masks = check_masks({**head_masks(), **settings.masks}, len(load_head().vertices))
    used = np.unique(np.concatenate(list(masks.values())))
    return used, {name: np.searchsorted(used, rows) for name, rows in masks.items()}


def _known(vertices: int) -> tuple[Mapping[str, Rows], MeshLandmarks | None]:
    """Regions and landmarks of MediaPipe's face mesh and of the reference face, by their number of points."""
    if vertices == FACE_MESH:
        return _of_points(np.arange(FACE_MESH))
    indices = load_face(find_model(DEFAULT_MODEL) / "face.safetensors").indices
    return _of_points(indices) if vertices == len(indices) else ({}, None)


def _of_points(numbers: Rows) -> tuple[Mapping[str, Rows], MeshLandmarks]:
    """Landmarks that are vertices, (landmarks,) face-mesh numbers."""
    rows = np.arange(len(numbers))
    spots = MeshLandmarks(numbers, np.column_stack([rows] * 3), np.tile([1.0, 0.0, 0.0], (len(rows), 1)))
    regions = {name: np.flatnonzero(np.isin(numbers, mine)) for name, mine in landmark_numbers().items()}
    return regions, spots


def landmark_lips(landmarks: Array, numbers: Rows) -> dict[str, Array]:
    """Lip curves of landmarks, (frames, landmarks, 3) mm, y up and z forward; -> (frames,) mm each.

    `numbers` (landmarks,) are face-mesh numbers.
    """
    count = len(numbers)
    face = FaceModel(np.zeros((count, 3)), np.zeros((0, count, 3)), np.zeros(0), numbers)
    measures = {"aperture": lip_aperture, "width": lip_width, "protrusion": lip_protrusion}
    upper = landmarks[:, face.landmark(UPPER_LIP_INNER), 1]
    return {name: measure(landmarks, face) for name, measure in measures.items()} | {"upper_lip": upper}


def _own_lips(points: Array, lips: tuple[int, ...]) -> dict[str, Array]:
    """Lip curves of four vertices: distances of upper and lower lip, and of the corners."""
    if len(lips) != 4 or not all(0 <= row < points.shape[1] for row in lips):
        raise EvaluationError(
            f"lip vertices {lips}: four below {points.shape[1]} are needed: upper, lower, right corner, left"
        )
    upper, lower, right, left = (points[:, row] for row in lips)
    return {
        "aperture": np.linalg.norm(upper - lower, axis=1),
        "width": np.linalg.norm(right - left, axis=1),
    }


def _scale(motion: Vertices, unit: str | None) -> tuple[float, tuple[str, ...]]:
    """Millimetres per unit of the file: the given unit, or the one that makes the mesh as large as a head."""
    if unit is not None:
        return UNITS[unit], ()
    size = float(np.ptp(motion.points[0], axis=0).max())
    guess = next((name for name, largest in LARGEST.items() if size < largest), "mm")
    return UNITS[guess], (
        f"the mesh is {size:.3g} units high or wide: coordinates taken as {guess} (--unit)",
    )
