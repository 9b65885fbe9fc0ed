from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from phonanim.errors import RigError
from phonanim.face.contacts import closed_shape
from phonanim.face.correspondence import map_faces
from phonanim.face.model import FaceModel, lip_aperture, lip_width
from phonanim.rig.reference import face_notes, move_to_face, shipped_face


def other_speaker() -> FaceModel:
    """The shipped face on a longer head, with its mouth further open on average, in modes of its own."""
    face = shipped_face()
    rng = np.random.default_rng(3)
    turn, _ = np.linalg.qr(rng.normal(size=(8, 8)))
    mean = face.mean * [1.0, 1.08, 1.0] + 0.5 * face.std[0] * face.modes[0]
    modes = np.tensordot(turn, face.modes[:8], axes=1)
    return FaceModel(mean, modes, np.linspace(9.0, 2.0, 8), face.indices)


def speech(face: FaceModel, frames: int = 300) -> np.ndarray:
    return np.random.default_rng(1).normal(size=(frames, len(face.std))) * face.std


def test_lips_of_another_speaker_move_by_the_same_millimetres() -> None:
    source, target = other_speaker(), shipped_face()
    modes = speech(source)
    shown = target.instance(map_faces(source, target)(modes))
    for measure in (lip_aperture, lip_width):
        moved = measure(source.instance(modes), source) - measure(closed_shape(source)[None], source)
        seen = measure(shown, target) - measure(closed_shape(target)[None], target)
        assert np.polyfit(moved, seen, 1)[0] == pytest.approx(1, abs=0.03)
        assert np.corrcoef(moved, seen)[0, 1] > 0.99


def test_closed_lips_stay_closed() -> None:
    source, target = other_speaker(), shipped_face()
    closed = source.project(closed_shape(source)[None])
    gap = lip_aperture(target.instance(map_faces(source, target)(closed)), target)
    assert abs(gap[0] - lip_aperture(closed_shape(target)[None], target)[0]) < 0.05


def test_a_face_maps_to_itself_unchanged() -> None:
    face = shipped_face()
    modes = speech(face)
    assert map_faces(face, replace(face))(modes) == pytest.approx(modes, abs=1e-3)


def test_few_common_landmarks_are_refused() -> None:
    face = shipped_face()
    moving = np.flatnonzero(face.moving)[:10]
    few = FaceModel(face.mean[moving], face.modes[:, moving], face.std, face.indices[moving])
    with pytest.raises(RigError, match="have 10 moving landmarks in common; at least 12"):
        map_faces(few, face)


def test_the_share_that_is_shown_is_said() -> None:
    source, target = other_speaker(), shipped_face()
    assert face_notes(source, target.id)[0].startswith("the model's face is not the rig's; 100%")
    assert face_notes(target, target.id) == ()


def test_a_face_that_nobody_has_is_refused() -> None:
    source = other_speaker()
    with pytest.raises(RigError, match="rig hero was made for the reference face 012345"):
        move_to_face(speech(source), source, "012345", "rig hero")
