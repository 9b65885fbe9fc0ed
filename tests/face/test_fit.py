"""The fit of the reference face: principal components, kept and signed by our rules."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest
from speech import made_up_face

from phonanim.errors import CorpusError, MissingExtraError
from phonanim.face.fit import fit_face
from phonanim.face.model import FaceModel


@pytest.fixture
def shapes() -> np.ndarray:
    face = made_up_face(np.random.default_rng(0))
    return face.instance(np.random.default_rng(1).normal(size=(300, len(face.std))) * face.std)


@pytest.fixture
def indices() -> np.ndarray:
    return made_up_face(np.random.default_rng(0)).indices


def test_modes_are_eigenvectors_of_the_covariance(shapes: np.ndarray, indices: np.ndarray) -> None:
    face = fit_face(shapes, indices)
    centred = (shapes - shapes.mean(axis=0))[:, face.moving].reshape(len(shapes), -1)
    covariance = centred.T @ centred / len(centred)
    flat = face.modes[:, face.moving].reshape(len(face.std), -1)
    np.testing.assert_allclose(covariance @ flat.T, flat.T * face.std**2, atol=1e-9)
    energy = np.linalg.eigvalsh(covariance)[::-1]
    np.testing.assert_allclose(face.std**2, energy[: len(face.std)], rtol=1e-9)


@pytest.mark.parametrize("variance", [0.5, 0.9, 0.99])
def test_the_fewest_modes_that_keep_the_variance(
    shapes: np.ndarray, indices: np.ndarray, variance: float
) -> None:
    face = fit_face(shapes, indices, variance)
    moved = (shapes - face.mean)[:, face.moving]
    kept = np.cumsum(face.std**2) / (moved**2).sum() * len(shapes)
    assert kept[-1] >= variance
    assert (kept[:-1] < variance).all()


def test_a_face_known_but_for_rounding_is_returned_itself(shapes: np.ndarray, indices: np.ndarray) -> None:
    fitted = fit_face(shapes, indices)
    stored = FaceModel(
        *(part.astype(np.float32).astype(float) for part in (fitted.mean, fitted.modes, fitted.std)), indices
    )
    assert fit_face(shapes, indices, known=stored) is stored
    for other in (
        replace(stored, mean=stored.mean + 1e-4),
        replace(stored, modes=stored.modes[:-1], std=stored.std[:-1]),
        replace(stored, indices=indices[::-1]),
    ):
        np.testing.assert_array_equal(fit_face(shapes, indices, known=other).modes, fitted.modes)


def test_a_face_without_landmarks_below_the_nose_is_refused(shapes: np.ndarray, indices: np.ndarray) -> None:
    shapes[:, :, 1] = 0.0
    with pytest.raises(CorpusError, match="no landmark of the corpus lies below the nose; track"):
        fit_face(shapes, indices)


def test_the_fit_needs_scikit_learn(
    shapes: np.ndarray, indices: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "sklearn.decomposition", None)
    with pytest.raises(MissingExtraError, match=r"with scikit-learn; .*pip install 'phonanim\[train\]'"):
        fit_face(shapes, indices)
