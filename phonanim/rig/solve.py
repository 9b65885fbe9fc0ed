"""Landmarks -> controls, frame by frame (Medina 2023, section 3.3.1).

The energy of Medina's equation 3.5 (squared distances to the displaced landmarks, an L1 prior, one value
for both sides of the face) with three additions: the visible distances of a mouth (the gap between the lips,
their width, their protrusion) have terms of their own, neighbouring frames are tied, and lips that touch on
the speaker touch on the rig. Medina runs L-BFGS from the previous frame. Blendshapes add up linearly, so
here each control has a closed-form optimum and all frames are solved together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import RigError
from phonanim.face.model import FaceModel
from phonanim.rig.coordinate_descent import Problem, descend
from phonanim.rig.landmark_objective import Energy, observe_displacements, target_observations
from phonanim.rig.landmark_rig import LandmarkRig, control_partners, landmark_partners, mirror_faces
from phonanim.rig.rig import Rig

Array = NDArray[np.float64]

FILM = Energy()


def solve(
    shapes: Array,
    face: FaceModel,
    landmark_rig: LandmarkRig,
    rig: Rig,
    closed: Array,
    energy: Energy = FILM,
    lengths: NDArray[np.int64] | None = None,
    proposal: Array | None = None,
) -> Array:
    """Controls that move the landmark_rig as the face moves, (frames, landmarks, 3) mm -> (frames, controls).

    `closed` (landmarks, 3) is the face with closed lips, which corresponds to the rig at rest; `lengths` are
    the clips' frame counts (one clip when None); `proposal` (frames, controls) pulls the solution to
    itself by `energy.near`. Controls that speech does not move stay at rest. Raises RigError when
    the landmark_rig has none of the rig's speech controls.
    """
    unknowns = Unknowns.of(landmark_rig, rig)
    seen = observe_displacements(unknowns.shapes(landmark_rig), face, energy)
    gram, pull = seen @ seen.T, target_observations(shapes, closed, face, landmark_rig, energy) @ seen.T
    start = np.zeros_like(pull)
    if proposal is not None:
        start = unknowns.from_controls(proposal)
        gram, pull = gram + energy.near * np.eye(len(gram)), pull + energy.near * start
    ends = np.cumsum([len(shapes)] if lengths is None else lengths)
    sparse = np.full(len(gram), energy.sparse)
    problem = Problem(gram, pull, unknowns.minimum, unknowns.maximum, sparse, energy.smooth, ends)
    return unknowns.to_controls(descend(problem, start))


@dataclass(frozen=True)
class Unknowns:
    """The unknowns: one value per control or symmetric pair of controls, measured from rest.

    `spread` (unknowns, controls) converts unknowns to controls; `rows` (unknowns,) is the first control of
    each. Where control a may not exceed control b (mouthClose and jawOpen), b is a plus a non-negative
    unknown, so that simple bounds are enough.
    """

    rig: Rig
    rows: NDArray[np.int64]
    spread: Array
    minimum: Array
    maximum: Array

    @classmethod
    def of(cls, landmark_rig: LandmarkRig, rig: Rig) -> Unknowns:
        """The unknowns of the speech controls that the landmark_rig has."""
        landmark_rig = landmark_rig.take(tuple(name for name in landmark_rig.controls if name in rig.speech))
        if not landmark_rig.controls:
            raise RigError(f"the head has none of the speech controls of rig {rig.name}; check `speech`")
        partner = control_partners(landmark_rig)
        leads = np.flatnonzero(np.arange(len(partner)) <= partner)
        columns = np.array([rig.controls.index(name) for name in landmark_rig.controls])
        rows = columns[leads]
        spread = np.zeros((len(leads), len(rig.controls)))
        spread[np.arange(len(leads)), rows] = 1.0
        spread[np.arange(len(leads)), columns[partner[leads]]] = 1.0
        minimum, maximum = (rig.minimum - rig.rest)[rows], (rig.maximum - rig.rest)[rows]
        for low, high in rig.at_most:
            if low in rows and high in rows:
                spread[rows == low, high] = 1.0
                minimum[rows == high] = 0.0
        return cls(rig, rows, spread, minimum, maximum)

    def shapes(self, landmark_rig: LandmarkRig) -> Array:
        """The motion of each unknown, symmetric, (unknowns, landmarks, 3) mm."""
        known = [name for name in landmark_rig.controls if name in self.rig.speech]
        columns = [self.rig.controls.index(name) for name in known]
        summed = np.tensordot(self.spread[:, columns], landmark_rig.take(tuple(known)).shapes, axes=1)
        return np.asarray((summed + mirror_faces(summed, landmark_partners(landmark_rig.rest))) / 2)

    def to_controls(self, values: Array) -> Array:
        """(frames, unknowns) -> (frames, controls), within the limits."""
        controls = self.rig.rest + values @ self.spread
        return np.asarray(np.clip(controls, self.rig.minimum, self.rig.maximum))

    def from_controls(self, controls: Array) -> Array:
        """(frames, controls) -> (frames, unknowns)."""
        values = (controls - self.rig.rest)[:, self.rows]
        for low, high in self.rig.at_most:
            if low in self.rows and high in self.rows:
                values[:, self.rows == high] -= values[:, self.rows == low]
        return np.asarray(np.clip(values, self.minimum, self.maximum))
