"""The reference face that a rig was made for, and motion of another face on it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.core.catalog import DEFAULT_MODEL, find_model
from phonanim.errors import RigError
from phonanim.face.correspondence import map_faces
from phonanim.face.model import FaceModel
from phonanim.regressors import load_face


@lru_cache(maxsize=1)
def shipped_face() -> FaceModel:
    """The reference face of the model that ships with the package; the shipped rigs were made for it."""
    return load_face(find_model(DEFAULT_MODEL) / "face.safetensors")


def move_to_face(
    modes: NDArray[np.floating], face: FaceModel, wanted: str, name: str
) -> tuple[NDArray[np.floating], FaceModel]:
    """Modes of `face`, (frames, m), as modes of the face with the id `wanted`, and that face.

    Unchanged when the ids are equal or `wanted` is empty. A face other than the model's own can only be the
    shipped one. `name` is what was made for it, for the error. Raises RigError for any other face.
    """
    if wanted in ("", face.id):
        return modes, face
    target = shipped_face()
    if wanted != target.id:
        raise RigError(
            f"{name} was made for the reference face {wanted}, but the model's is {face.id}; "
            "use the model it was made with, or fit the rig again: phonanim rig fit"
        )
    return map_faces(face, target)(modes), target


def face_notes(face: FaceModel, wanted: str) -> tuple[str, ...]:
    """What is lost when modes of `face` move a rig made for the face with the id `wanted`."""
    if wanted in ("", face.id) or wanted != shipped_face().id:
        return ()
    shown = 1 - map_faces(face, shipped_face()).residual
    return (f"the model's face is not the rig's; {shown:.0%} of its motion is shown, by common landmarks",)
