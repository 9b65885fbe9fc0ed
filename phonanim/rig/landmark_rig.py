"""A rig for the solver: its landmarks at rest and the motion of each control, in the face's axes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import RigError
from phonanim.face.model import FaceModel
from phonanim.rig.head import TONGUE, Head
from phonanim.rig.landmarks import MeshLandmarks
from phonanim.rig.neck import TURNS

Array = NDArray[np.float64]
EYES = ((33, 133), (362, 263))  # the corners of the right and of the left eye
SLANT = 35.0  # degrees that a head may lean: faces differ in what they take as straight ahead
ALIKE = 0.5  # two controls are partners when their mirrored motions differ by less than this fraction


@dataclass(frozen=True)
class LandmarkRig:
    """The landmarks of a head at rest and under each control at full weight.

    `controls` are names, `rest` (landmarks, 3) and `shapes` (controls, landmarks, 3) millimetres in the
    axes and the size of the reference face (eyes as far apart), rows as in `FaceModel.indices`.
    """

    controls: tuple[str, ...]
    rest: Array
    shapes: Array

    def pose(self, values: NDArray[np.floating]) -> Array:
        """Landmarks under control values, (frames, controls) -> (frames, landmarks, 3) mm."""
        flat = np.asarray(values, np.float64) @ self.shapes.reshape(len(self.shapes), -1)
        return self.rest + flat.reshape(-1, *self.rest.shape)

    def take(self, controls: tuple[str, ...]) -> LandmarkRig:
        """Only these controls. Turns of the head explain nothing in a face whose head is held still."""
        rows = [-1 if control in TURNS else self.controls.index(control) for control in controls]
        still = np.append(self.shapes, np.zeros_like(self.shapes[:1]), axis=0)
        return replace(self, controls=controls, shapes=still[rows])


def make_landmark_rig(head: Head, landmarks: MeshLandmarks, face: FaceModel) -> LandmarkRig:
    """The landmarks of a head, converted to the reference face's axes and size. Raises RigError.

    The shipped head's tongue is left out, because no landmark shows it.
    """
    spots = landmarks.take(face.indices.tolist())
    head = to_face_axes(head.without(TONGUE), landmarks, face)
    return LandmarkRig(head.targets, spots.of(head.vertices), spots.of(head.deltas))


def to_face_axes(head: Head, landmarks: MeshLandmarks, face: FaceModel) -> Head:
    """A head in the reference face's axes and size, in millimetres, the middle of its eyes at the origin.

    Heads are modelled along the axes, so the rotation is the signed permutation of axes nearest to the best
    rotation (Umeyama 1991). Raises RigError when the landmarks do not resemble a face.
    """
    spots = landmarks.take(face.indices.tolist())
    turn = _snap(_rotation(spots.of(head.vertices), face.mean))
    vertices = head.vertices @ turn
    centres, own = eye_centres(spots.of(vertices), face), eye_centres(face.mean, face)
    apart = float(np.linalg.norm(centres[1] - centres[0]))
    if apart == 0:
        raise RigError(
            "the landmarks of the two eyes (33, 133; 362, 263) coincide; correct the landmark table"
        )
    scale = float(np.linalg.norm(own[1] - own[0])) / apart
    moved = (vertices - centres.mean(axis=0)) * scale
    return replace(head, vertices=moved, deltas=head.deltas @ turn * scale)


def eye_centres(points: Array, face: FaceModel) -> Array:
    """The middles of the right and the left eye, (landmarks, 3) -> (2, 3)."""
    return np.array([points[face.rows(corners)].mean(axis=0) for corners in EYES])


def _rotation(points: Array, target: Array) -> Array:
    """Least-squares rotation of points onto a target, to multiply from the right."""
    left, _, right = np.linalg.svd((points - points.mean(axis=0)).T @ (target - target.mean(axis=0)))
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    return np.asarray(left @ right)


def _snap(rotation: Array) -> Array:
    snapped = np.where(np.abs(rotation) > np.cos(np.radians(SLANT)), np.sign(rotation), 0.0)
    if not np.isclose(np.linalg.det(snapped), 1.0):
        raise RigError("the head does not stand along the axes; turn it upright and apply the rotation")
    return snapped


def mirror_faces(shapes: Array, partner: NDArray[np.int64]) -> Array:
    """Mirrored faces, (..., landmarks, 3) -> the same shape."""
    return np.asarray(shapes[..., partner, :] * (-1.0, 1.0, 1.0))


def landmark_partners(rest: Array) -> NDArray[np.int64]:
    """The landmark on the other side of each, (landmarks, 3) -> (landmarks,)."""
    flipped = rest * (-1.0, 1.0, 1.0)
    return np.asarray(np.linalg.norm(flipped[:, None] - rest[None], axis=2).argmin(axis=1))


def control_partners(landmark_rig: LandmarkRig) -> NDArray[np.int64]:
    """The control that does the same on the other side, (controls,); itself for a symmetric control."""
    flat = landmark_rig.shapes.reshape(len(landmark_rig.shapes), -1)
    flipped = mirror_faces(landmark_rig.shapes, landmark_partners(landmark_rig.rest)).reshape(flat.shape)
    apart = np.linalg.norm(flipped[:, None] - flat[None], axis=2)
    nearest = apart.argmin(axis=1)
    mutual = nearest[nearest] == np.arange(len(flat))
    alike = apart.min(axis=1) < ALIKE * np.linalg.norm(flat, axis=1).clip(1e-9)
    return np.where(mutual & alike, nearest, np.arange(len(flat)))
