"""Measure a head: the effect of each of its controls on the mouth (phonanim/rig/measures.py)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from phonanim.face.model import (
    LOWER_LIP_INNER,
    MOUTH_CORNER_LEFT,
    MOUTH_CORNER_RIGHT,
    UPPER_LIP_INNER,
    FaceModel,
)
from phonanim.rig.head import Head
from phonanim.rig.landmark_rig import to_face_axes
from phonanim.rig.landmarks import MeshLandmarks
from phonanim.rig.measures import MEASURES, USES, MouthMeasures
from phonanim.rig.morphs import plain_name

Array = NDArray[np.float64]

# Upper and lower inner lips from the middle to the corner, both sides averaged.
GAP_PAIRS = (((13, 14),), ((82, 87), (312, 317)), ((81, 178), (311, 402)), ((80, 88), (310, 318)))
UPPER_LIP_FRONT = 0
CHIN = 152
TEETH = ("teeth_u", "teeth_l")
# mm of the lower lip above and in front of the upper incisors' edge, as on the shipped head
TEETH_BEHIND = 2.4, 4.1
INCISORS = 3.0  # mm to either side of the middle
TONGUE_PART = "tongue"
SENSORS, WITHIN = (8.0, 45.0), 5.0  # mm behind the foremost point of the tongue, and how near a point must be
SIDES = ("", "Left", "Right")
ALWAYS = "free closed tucked"
SHAPE = "free tucked shared"  # visemes: several mix, and lips close by their absence
CLOSING = -0.8  # mm of lip gap: a viseme that closes them as far presses them together
ARKIT = {
    "jawOpen": (ALWAYS, 0.5),
    "mouthClose": (ALWAYS, 0.5),
    "mouthLowerDown": ("free tucked", 3.0),
    "mouthUpperUp": ("free tucked", 3.0),
    "mouthFunnel": ("free", 6.0),
    "mouthPucker": (ALWAYS, 2.0),
    "mouthStretch": (ALWAYS, 3.0),
    "mouthSmile": (ALWAYS, 4.0),
    "mouthRollLower": ("tucked", 1.0),
    "mouthShrugLower": ("closed tucked", 3.0),
    "mouthPress": ("pressed", 3.0),
}
"""When each ARKit control is used in speech, and the cost of its full weight in mm²: set by eye."""


def measure(
    head: Head, landmarks: MeshLandmarks, face: FaceModel, controls: Mapping[str, tuple[str, float]]
) -> MouthMeasures:
    """The measures of a head, in the size of the reference face.

    `controls` gives the uses and the effort of each. A name without a side, in ARKit's spelling, means both
    sides. Controls that the head lacks are left out. Where no parts are detected as teeth, the chin is
    measured in place of the jaw.
    """
    head = to_face_axes(head, landmarks, face)
    plainly = {plain_name(target): target for target in head.targets}
    grouped = {
        stem: tuple(plainly[name] for side in SIDES if (name := plain_name(stem + side)) in plainly)
        for stem in controls
    }
    controls = {stem: of for stem, of in controls.items() if grouped[stem]}
    names = [grouped[stem] for stem in controls]
    moves = np.array([sum(head.deltas[head.targets.index(name)] for name in group) for group in names])
    effects, rest = mouth_effects(replace(head, targets=tuple(controls), deltas=moves), landmarks)
    uses = np.array([[use in when.split() for use in USES] for when, _ in controls.values()])
    closing = uses[:, USES.index("shared")] & (effects[:, MEASURES.index("gap")] < CLOSING)
    uses[closing] = [use in ("pressed", "shared") for use in USES]
    return MouthMeasures(
        names=tuple(names),
        uses=uses,
        effort=np.array([effort for _, effort in controls.values()]),
        moved=effects,
        rest=rest,
    )


def mouth_effects(head: Head, landmarks: MeshLandmarks) -> tuple[Array, Array]:
    """The measures that each shape of a head moves, and those at rest: (targets, measures), (measures,) mm.

    The head is in the axes and the size of the reference face.
    """
    edges = incisors(head)
    moved = [_mouth(move, landmarks, edges, False) for move in head.deltas]
    return np.array(moved), _mouth(head.vertices, landmarks, edges, True)


def tongue_effects(head: Head) -> Array | None:
    """How far each shape moves the tongue's tip and body up and forward, (targets, 4) mm; none without one.

    The tip is measured on top of it, the body where it is highest, SENSORS mm behind its foremost point, as
    far back as sensors are glued.
    """
    if TONGUE_PART not in head.parts:
        return None
    rows = head.parts[TONGUE_PART]
    points = head.vertices[rows]
    reach = points[:, 2].max()
    places = []
    for behind in SENSORS:
        near = np.flatnonzero(
            (np.abs(points[:, 2] - reach + behind) < WITHIN) & (np.abs(points[:, 0]) < INCISORS)
        )
        places.append(rows.start + near[points[near, 1].argmax()])
    return np.column_stack([head.deltas[:, place, axis] for place in places for axis in (1, 2)])


def incisors(head: Head) -> tuple[int, int] | None:
    """The vertices at the edges of upper and lower incisors; none where no teeth are detected."""
    if not set(TEETH) <= set(head.parts):
        return None
    found = []
    for part, sign in zip(TEETH, (-1, 1), strict=True):
        rows = head.parts[part]
        middle = np.flatnonzero(np.abs(head.vertices[rows, 0]) < INCISORS)
        found.append(rows.start + middle[(sign * head.vertices[rows][middle, 1]).argmax()])
    return int(found[0]), int(found[1])


def _mouth(points: Array, landmarks: MeshLandmarks, edges: tuple[int, int] | None, rest: bool) -> Array:
    """The measures of points at rest, or of what a control moves, (n, 3) mm -> (measures,)."""
    at = {int(number): row for row, number in enumerate(landmarks.numbers)}
    spots = landmarks.of(points)
    gaps = [np.mean([spots[at[a], 1] - spots[at[b], 1] for a, b in pairs]) for pairs in GAP_PAIRS]
    if rest:
        lower = spots[at[LOWER_LIP_INNER]] - points[edges[0]] if edges else np.array([0.0, *TEETH_BEHIND])
        return np.array([0.0, *gaps, 0.0, 0.0, 0.0, *lower[1:]])
    width = spots[at[MOUTH_CORNER_LEFT], 0] - spots[at[MOUTH_CORNER_RIGHT], 0]
    drop = points[edges[0], 1] - points[edges[1], 1] if edges else -spots[at[CHIN], 1]
    upper, front = spots[at[UPPER_LIP_INNER], 1], spots[at[UPPER_LIP_FRONT], 2]
    return np.array([drop, *gaps, width, front, upper, *spots[at[LOWER_LIP_INNER]][1:]])
