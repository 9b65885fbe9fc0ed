"""Blendshapes for a head that has none: the shipped head's, by deformation transfer.

The model is warped onto the new head, whose skin then follows the corresponding triangles. Parts inside the
face move along, and triangles that a shape flips are corrected. Needs scipy.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim.face.model import INNER_LIPS
from phonanim.rig.align import Surface, align_bare_head, face_rows, surface_of
from phonanim.rig.deform import Deformation
from phonanim.rig.head import TONGUE, Head
from phonanim.rig.interior_parts import carry_parts, outer_rows
from phonanim.rig.landmarks import MeshLandmarks
from phonanim.rig.register import Pins, place_landmarks, warp_surface
from phonanim.rig.unflip import unflip

Array = NDArray[np.float64]

MARGIN = 0.05  # metres around the landmarks: chin, neck and temples move too


@dataclass(frozen=True)
class Report:
    """How well two heads matched.

    `matched` is the share of the skin's triangles that correspond to one of the model's, `carried` says
    what the parts inside the face follow, `straightened` counts the shapes in which triangles were turned
    over and turned back, `flipped` the triangles, in all shapes, that are still turned over.
    """

    matched: float
    carried: dict[str, str]
    straightened: int
    flipped: int


def transfer(model: Head, spots: MeshLandmarks, target: Head) -> tuple[Head, MeshLandmarks, Report]:
    """Give a head without shapes the model's, and the landmarks that were found on it.

    The skin deforms; teeth, tongue and eyes follow the model's as rigid bodies, the rest follows the skin.
    Shapes that move only the model's tongue are left out. Raises RigError when the heads cannot be aligned,
    MissingExtraError without scipy.
    """
    model = model.without(TONGUE)
    onto = align_bare_head(model, spots, target)
    skin = np.isin(target.triangles, outer_rows(target)).all(axis=1)
    theirs = Surface(onto(target.vertices), target.triangles[skin], np.zeros(len(target.vertices)))
    warped, found = match_heads(model, spots, theirs)
    system = Deformation(model, spots, warped, theirs, found)
    moved = np.array([system.shape(delta) for delta in model.deltas])
    carried = carry_parts(model, target, theirs.points, moved)
    solved = [unflip(theirs.points, delta, target.triangles) for delta in moved]
    straight, flipped = np.array([delta for delta, _ in solved]), sum(count for _, count in solved)
    straightened = int((straight != moved).any(axis=(1, 2)).sum())
    back = np.linalg.inv(onto(np.eye(3)) - onto(np.zeros((1, 3))))
    head = replace(target, targets=model.targets, deltas=straight @ back)
    return head, found, Report(system.matched_share, carried, straightened, flipped)


def match_heads(model: Head, spots: MeshLandmarks, theirs: Surface) -> tuple[Surface, MeshLandmarks]:
    """The model warped onto a bare skin, and the landmarks there.

    The first warp finds the lips; the lip rims that are detected there pin the second warp.
    """
    mine, rows = surface_of(model), face_rows(model, spots, MARGIN)
    mine, theirs = (replace(surface, opening=0 * surface.opening) for surface in (mine, theirs))
    found = place_landmarks(warp_surface(mine, theirs, rows), spots, theirs)
    pins = Pins(spots.take(INNER_LIPS), found.take(INNER_LIPS).of(theirs.points))
    return warp_surface(mine, theirs, rows, pins), found
