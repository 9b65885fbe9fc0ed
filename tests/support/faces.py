"""A reference face without recordings: the shipped head's landmarks, moved by a few of its shapes."""

from __future__ import annotations

from functools import cache

import numpy as np

from phonanim.face.model import FaceModel
from phonanim.rig import Rig, load_rig
from phonanim.rig.head import TONGUE, load_head
from phonanim.rig.landmark_rig import LandmarkRig, landmark_partners, mirror_faces
from phonanim.rig.landmarks import read_landmarks

SHAPES = (
    ("jawOpen",),
    ("mouthPucker",),
    ("mouthStretchLeft", "mouthStretchRight"),
    ("mouthLowerDownLeft", "mouthLowerDownRight"),
    ("mouthUpperUpLeft", "mouthUpperUpRight"),
)


@cache
def head_landmark_rig() -> LandmarkRig:
    """The shipped head's landmarks in the axes and size of a reference face."""
    head, spots = load_head().without(TONGUE), read_landmarks(load_rig("arkit").landmarks)
    rest = spots.of(head.vertices)
    eyes = rest[[33, 133, 362, 263]].mean(axis=0)
    return LandmarkRig(head.targets, (rest - eyes) * 1000, spots.of(head.deltas) * 1000)


@cache
def head_face() -> FaceModel:
    """A face whose mean is the head a little open and whose five modes span SHAPES, symmetric."""
    landmark_rig = head_landmark_rig()
    partner = landmark_partners(landmark_rig.rest)
    shapes = np.array(
        [sum(landmark_rig.shapes[landmark_rig.controls.index(n)] for n in names) for names in SHAPES]
    )
    shapes = (shapes + mirror_faces(shapes, partner)) / 2
    basis, triangle = np.linalg.qr(shapes.reshape(len(shapes), -1).T)
    basis = (basis * np.sign(np.diag(triangle))).T.reshape(shapes.shape)  # each mode goes the shape's way
    mean = landmark_rig.rest + 0.1 * shapes[0]
    return FaceModel(mean, basis, np.array([20.0, 9.0, 6.0, 5.0, 4.0]), np.arange(len(mean)))


def blank_rig(landmark_rig: LandmarkRig, **changes: object) -> Rig:
    """The landmark_rig's controls from 0 to 1, not fitted to anything."""
    count = len(landmark_rig.controls)
    facts = {
        "name": "blank",
        "title": "",
        "source": "",
        "controls": landmark_rig.controls,
        "minimum": np.zeros(count),
        "maximum": np.ones(count),
        "rest": np.zeros(count),
        "mean": np.zeros(count),
        "poses": np.zeros((0, count)),
        "speech": load_rig("arkit").speech,
        "at_most": load_rig("arkit").at_most,
    }
    return Rig(**{**facts, **changes})
