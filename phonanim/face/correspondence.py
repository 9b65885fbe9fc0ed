"""From the modes of one reference face to those of another, by the landmarks that both have."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import RigError
from phonanim.face.contacts import closed_shape
from phonanim.face.model import FaceModel

Array = NDArray[np.float64]

FEWEST = 12  # landmarks that move, in common; fewer do not tell one motion of the mouth from another


@dataclass(frozen=True, eq=False)
class FaceMap:
    """Affine map of shape parameters: p_target = p_source · `weights` + `offset`.

    `weights` is (source modes, target modes), `offset` (target modes,) mm. `residual` is the share of the
    source's variance in speech that the target's modes cannot show, 0 to 1.
    """

    weights: Array
    offset: Array
    residual: float

    def __call__(self, modes: NDArray[np.floating]) -> NDArray[np.float32]:
        """(frames, source modes) -> (frames, target modes)."""
        return np.asarray(modes @ self.weights + self.offset, np.float32)


@lru_cache(maxsize=16)
def map_faces(source: FaceModel, target: FaceModel) -> FaceMap:
    """The map under which landmarks of the same number move alike, from closed lips to closed lips.

    Displacements keep their millimetres: both faces have their pupils 63 mm apart. The target's parameters
    are the least squares solution. Lips that touch in the source touch in the target, because displacements
    start at the face with its lips closed that is nearest to each mean. Raises RigError when the faces have
    too few moving landmarks in common.
    """
    numbers = np.intersect1d(source.indices[source.moving], target.indices[target.moving])
    if len(numbers) < FEWEST:
        raise RigError(
            f"the faces {source.id} and {target.id} have {len(numbers)} moving landmarks in common; at least "
            f"{FEWEST} are needed; train the model on landmarks of MediaPipe's face mesh"
        )
    theirs, ours = source.rows(numbers), target.rows(numbers)
    moves = source.modes[:, theirs].reshape(len(source.std), -1)
    basis = target.modes[:, ours].reshape(len(target.std), -1)
    start = (source.mean - closed_shape(source))[theirs].ravel()
    shown = (target.mean - closed_shape(target))[ours].ravel()
    weights, *_ = np.linalg.lstsq(basis.T, moves.T, rcond=None)
    offset, *_ = np.linalg.lstsq(basis.T, start - shown, rcond=None)
    missed = ((weights.T @ basis - moves) ** 2).sum(axis=1) @ source.std**2
    residual = float(missed / ((moves**2).sum(axis=1) @ source.std**2))
    return FaceMap(weights.T, offset, residual)
