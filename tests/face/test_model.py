"""Laws of the face model."""

from __future__ import annotations

import numpy as np
import pytest
from speech import made_up_face

from phonanim.errors import ModelError
from phonanim.face.model import FaceModel, lip_aperture, lip_protrusion, lip_width


@pytest.fixture
def face() -> FaceModel:
    return made_up_face(np.random.default_rng(0))


def test_project_undoes_instance(face: FaceModel) -> None:
    weights = np.random.default_rng(1).normal(size=(6, len(face.std)))
    assert np.allclose(face.project(face.instance(weights)), weights, atol=1e-9)


def test_modes_are_orthonormal_and_sorted(face: FaceModel) -> None:
    flat = face.modes.reshape(len(face.modes), -1)
    assert np.allclose(flat @ flat.T, np.eye(len(flat)), atol=1e-12)
    assert (np.diff(face.std) <= 0).all()


def test_the_first_mode_opens_the_mouth(face: FaceModel) -> None:
    shapes = face.instance(np.eye(len(face.std))[:1] * face.std[0])
    assert lip_aperture(shapes, face)[0] > lip_aperture(face.mean[None], face)[0]


def test_what_lies_above_the_lip_is_rigid(face: FaceModel) -> None:
    assert not face.moving[face.rows((6, 168))].any()
    assert face.moving[face.rows((13, 14))].all()


def test_measures_are_millimetres(face: FaceModel) -> None:
    assert lip_aperture(face.mean[None], face)[0] == pytest.approx(3, abs=0.5)
    assert lip_width(face.mean[None], face)[0] == pytest.approx(50, abs=0.5)
    assert lip_protrusion(face.mean[None], face).shape == (1,)


def test_the_id_follows_the_modes(face: FaceModel) -> None:
    other = FaceModel(face.mean, face.modes[::-1], face.std, face.indices)
    assert face.id != other.id
    assert len(face.id) == 12


def test_a_landmark_that_is_not_there(face: FaceModel) -> None:
    with pytest.raises(ModelError, match="the reference face has no landmark 999"):
        face.landmark(999)
