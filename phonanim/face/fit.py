"""Fit the reference face to training shapes: principal components of the moving landmarks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import CorpusError, MissingExtraError
from phonanim.face.model import (
    LOWER_LIP_INNER,
    MOUTH_CORNER_LEFT,
    MOUTH_CORNER_RIGHT,
    SUBNASALE,
    UPPER_LIP_INNER,
    FaceModel,
)

Array = NDArray[np.float64]


ROUNDING = 1e-5  # millimetres: faces that differ by less are equal, up to float32 or another machine


def fit_face(
    shapes: NDArray[np.floating],
    indices: NDArray[np.int64],
    variance: float = 0.99,
    known: FaceModel | None = None,
) -> FaceModel:
    """Shape PCA of training shapes, (frames, landmarks, 3) mm, keeping `variance` of the energy.

    Only landmarks below the nose take part: blinks and brows are not speech. The sign of each mode is chosen
    so that its positive side opens the mouth (or, if it does not open it, raises the corners). So the poses
    can be named and the fit is repeatable. `known` is returned instead of a fit that equals it up to
    rounding, because rigs depend on its exact values. Raises MissingExtraError without scikit-learn, and
    CorpusError without landmarks below the nose.
    """
    try:
        from sklearn.decomposition import PCA
    except ImportError as error:
        raise MissingExtraError(
            "a face model is fitted with scikit-learn; install it with pip install 'phonanim[train]'"
        ) from error
    mean = shapes.mean(axis=0, dtype=np.float64)
    moving = mean[:, 1] < mean[np.flatnonzero(indices == SUBNASALE)[0], 1]
    if not moving.any():
        raise CorpusError("no landmark of the corpus lies below the nose; track the clips again")
    centred = (shapes[:, moving] - mean[moving]).reshape(len(shapes), -1).astype(np.float64)
    pca = PCA(variance, svd_solver="covariance_eigh").fit(centred)
    energy = pca.explained_variance_ * (1 - 1 / len(centred))  # variance over n frames instead of n - 1
    modes = np.zeros((len(energy), *mean.shape))
    modes[:, moving] = pca.components_.reshape(len(energy), -1, 3)
    face = FaceModel(mean, modes, np.sqrt(energy), np.asarray(indices, np.int64))
    face = FaceModel(mean, modes * _signs(face)[:, None, None], face.std, face.indices)
    return known if known is not None and _alike(face, known) else face


def _alike(face: FaceModel, other: FaceModel) -> bool:
    """Whether two faces are equal up to rounding."""
    pairs = ((face.mean, other.mean), (face.modes, other.modes), (face.std, other.std))
    same_rows = np.array_equal(face.indices, other.indices)
    return same_rows and all(a.shape == b.shape and np.allclose(a, b, 0, ROUNDING) for a, b in pairs)


def _signs(face: FaceModel) -> Array:
    upper, lower, right, left = face.rows(
        (UPPER_LIP_INNER, LOWER_LIP_INNER, MOUTH_CORNER_RIGHT, MOUTH_CORNER_LEFT)
    )
    opening = face.modes[:, upper, 1] - face.modes[:, lower, 1]
    raising = face.modes[:, right, 1] + face.modes[:, left, 1]
    deciding = np.where(np.abs(opening) > 0.02, opening, raising)
    return np.where(deciding < 0, -1.0, 1.0)
