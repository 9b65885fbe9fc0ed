"""The objective for comparing two mouths: landmarks, and the distances that viewers notice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.face.model import INNER_LIP_PAIRS, INNER_LIPS, OUTER_LIPS, FaceModel
from phonanim.rig.landmark_rig import LandmarkRig, landmark_partners, mirror_faces

Array = NDArray[np.float64]

CORNERS = ((61, 291), (78, 308))
FRONTS = (0, 17)  # the middles of the outer lips
CLOSED_GAP = 0.2  # mm: tracked lips that touch are this far apart or less
CHIN_WIDTH = 25.0  # mm to either side


@dataclass(frozen=True)
class Energy:
    """Weights of displacements in mm and of control values.

    `lips`, `chin`, `skin` weigh each landmark on the lips' rims, the chin, and the rest below the nose,
    `depth` its z, which cameras measure worst; `gap`, `width`, `protrusion` the distances between lip points.
    `sparse` is the L1 prior per unit of control, `smooth` ties a frame to the next, `near` to a proposal.
    """

    lips: float = 1.0
    chin: float = 0.4
    skin: float = 0.15
    depth: float = 0.6
    gap: float = 3.0
    width: float = 5.0
    protrusion: float = 2.0
    sparse: float = 10.0
    smooth: float = 3.0
    near: float = 0.0


def observe_displacements(moved: Array, face: FaceModel, energy: Energy) -> Array:
    """Weighted observations from displacements, (n, landmarks, 3) mm -> (n, observations), gaps first."""
    weights = _landmark_weights(face, energy)
    points = (moved * weights[:, None] * (1.0, 1.0, energy.depth))[:, weights > 0]
    corners = face.rows(number for pair in CORNERS for number in pair).reshape(-1, 2)
    width = moved[:, corners[:, 1], 0] - moved[:, corners[:, 0], 0]
    parts = (
        energy.gap * lip_gaps(moved, face),
        points.reshape(len(moved), -1),
        energy.width * width,
        energy.protrusion * moved[:, face.rows(FRONTS), 2],
    )
    return np.concatenate(parts, axis=1)


def target_observations(
    shapes: Array, closed: Array, face: FaceModel, landmark_rig: LandmarkRig, energy: Energy
) -> Array:
    """Target observations of a landmark_rig for the face's `shapes`, (n, landmarks, 3) -> (n, observations).

    Displacements from `closed`, both sides averaged. Gaps are absolute, because lips that touch on the face
    must touch on a landmark_rig whose lips are a little apart at rest.
    """
    moved = shapes - closed
    moved = (moved + mirror_faces(moved, landmark_partners(landmark_rig.rest))) / 2
    wanted = observe_displacements(moved, face, energy)
    opened = np.maximum(lip_gaps(moved, face) - CLOSED_GAP, 0.0)
    wanted[:, : len(INNER_LIP_PAIRS)] = energy.gap * (opened - lip_gaps(landmark_rig.rest[None], face))
    return wanted


def lip_gaps(shapes: Array, face: FaceModel) -> Array:
    """Distances between facing points of the inner lips, (n, landmarks, 3) -> (n, pairs) mm."""
    pairs = face.rows(number for pair in INNER_LIP_PAIRS for number in pair).reshape(-1, 2)
    return np.asarray(shapes[:, pairs[:, 0], 1] - shapes[:, pairs[:, 1], 1])


def _landmark_weights(face: FaceModel, energy: Energy) -> Array:
    """The weight of each landmark, (landmarks,)."""
    across, height = np.abs(face.mean[:, 0]), face.mean[:, 1]
    rims = face.rows((*INNER_LIPS, *OUTER_LIPS))
    below = height < height[rims].min() - 3
    weights = np.where(face.moving, energy.skin, 0.0)
    weights[face.moving & below & (across < CHIN_WIDTH)] = energy.chin
    weights[face.moving & ~below & (across < across[rims].max())] = 0.6 * energy.lips
    weights[rims] = energy.lips
    return weights
