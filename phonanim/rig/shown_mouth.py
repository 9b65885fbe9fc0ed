"""What a rig's controls show of the mouth, in millimetres: the check of a solver on the rig's own head."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.face.model import FaceModel, lip_aperture, lip_protrusion, lip_width
from phonanim.rig.head import Head
from phonanim.rig.landmark_rig import to_face_axes
from phonanim.rig.landmarks import MeshLandmarks
from phonanim.rig.measures import MEASURES
from phonanim.rig.measuring import CHIN, mouth_effects, tongue_effects
from phonanim.rig.own_head import own_head
from phonanim.rig.rig import Rig, Through

Array = NDArray[np.float64]

SHOWN = ("lip_gap", "lip_width", "protrusion", "jaw", "lower_lip_to_teeth")
TONGUE = ("tongue_tip_height", "tongue_tip_front", "tongue_body_height", "tongue_body_front")
LIP_ON_TEETH = np.array([0.3, 0.6])  # mm up and forward from the incisors' edge, of a lower lip that meets it


@dataclass(frozen=True)
class ShownMouth:
    """Effects of a rig's controls, in mm of the reference face.

    `rest` (measures,) and `moved` (controls, measures) of MEASURES; `tongue` (controls, 4) of TONGUE.
    """

    rest: Array
    moved: Array
    tongue: Array | None

    def __call__(self, values: NDArray[np.floating]) -> dict[str, Array]:
        """The mouth under controls, (frames, controls) -> (frames,) mm by channel of articulation."""
        found = self.rest + values @ self.moved
        at = MEASURES.index
        lower = found[:, [at("lower_lip_up"), at("lower_lip_forward")]]
        shown = {
            "lip_gap": found[:, at("gap")],
            "lip_width": found[:, at("width")],
            "protrusion": found[:, at("protrusion")],
            "jaw": found[:, at("jaw")],
            "lower_lip_to_teeth": np.linalg.norm(lower - LIP_ON_TEETH, axis=1),
        }
        if self.tongue is not None:
            shown |= dict(zip(TONGUE, (values @ self.tongue).T, strict=True))
        return shown


def show_mouth(rig: Rig, controls: NDArray[np.floating], face: FaceModel) -> dict[str, Array] | None:
    """The mouth that controls show, (frames, controls) -> (frames,) mm by channel; none without a head.

    A rig that goes through another and has no head is shown on the other's, by the least-squares inverse of
    its table, so that what its controls lose is seen.
    """
    values: Array = np.asarray(controls, np.float64)
    if rig.articulated:
        return {name: values[:, rig.controls.index(name)] for name in (*SHOWN, *TONGUE)}
    if len(rig.controls) == 3 * len(face.indices):
        return _landmarks(values.reshape(len(values), -1, 3), rig, face)
    mouth = shown_mouth(rig, face)
    if mouth is None and rig.through is not None:
        return show_mouth(rig.through.rig, _back(values, rig.through), face)
    return None if mouth is None else mouth(values)


def shown_mouth(rig: Rig, face: FaceModel) -> ShownMouth | None:
    """The effects of a rig's controls on its own head; none without a head."""
    found = own_head(rig)
    return None if found is None else mouth_on(*found, rig.controls, face)


def mouth_on(head: Head, landmarks: MeshLandmarks, controls: tuple[str, ...], face: FaceModel) -> ShownMouth:
    """The effects of controls on a head, in its own axes and units."""
    head = to_face_axes(head, landmarks, face)
    effects, rest = mouth_effects(head, landmarks)
    spread = head.weights(np.eye(len(controls)), controls)
    tongue = tongue_effects(head)
    return ShownMouth(rest, spread @ effects, None if tongue is None else spread @ tongue)


def _back(values: Array, through: Through) -> Array:
    """The other rig's controls that a rig's controls stand for, (frames, own) -> (frames, other's)."""
    found = values @ np.linalg.pinv(through.table)
    for own, part, whole in through.shares:
        found[:, part] = values[:, own] * found[:, whole]
    return found


def _landmarks(shapes: Array, rig: Rig, face: FaceModel) -> dict[str, Array]:
    """The mouth of landmarks, (frames, landmarks, 3) mm; the chin in place of the jaw, and no teeth."""
    rest = rig.rest.reshape(1, -1, 3)
    chin = face.landmark(CHIN)
    return {
        "lip_gap": lip_aperture(shapes, face),
        "lip_width": lip_width(shapes, face) - lip_width(rest, face),
        "protrusion": lip_protrusion(shapes, face) - lip_protrusion(rest, face),
        "jaw": rest[:, chin, 1] - shapes[:, chin, 1],
    }
