"""A sample of the reference face's motion, to fit rigs without recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError
from phonanim.core.files import write_text
from phonanim.core.lexicon import LEXICON
from phonanim.core.tables import parse_cell, read_rows
from phonanim.errors import RigError
from phonanim.face.correspondence import map_faces
from phonanim.face.model import FaceModel, lip_aperture
from phonanim.rig.reference import shipped_face

Array = NDArray[np.float64]

SHIPPED = LEXICON / "rigs" / "motion.csv"


@dataclass(frozen=True)
class Motion:
    """Frames of speech: `standardized` (frames, modes) standard deviations of the modes of face `face`."""

    face: str
    standardized: Array

    def modes(self, face: FaceModel) -> Array:
        """Shape parameters, (frames, modes) mm; those of another face by the landmarks that both have.

        Raises RigError when the sample is neither of this face nor of the shipped one.
        """
        if self.face == face.id:
            return self.standardized * face.std
        source = shipped_face()
        if self.face != source.id:
            raise RigError(
                f"the motion sample is of the reference face {self.face}, the model's face is {face.id}; "
                "rebuild it: python scripts/fit_rig.py"
            )
        return map_faces(source, face)(self.standardized * source.std).astype(np.float64)


def sample_motion(modes: Array, face: FaceModel, frames: int, rng: np.random.Generator) -> Motion:
    """Draw frames for fitting, half of them with closed lips, (n, m) -> a Motion of `frames` frames."""
    shut = lip_aperture(face.instance(modes), face) < CLOSED_APERTURE
    halves = (np.flatnonzero(shut), frames // 2), (np.flatnonzero(~shut), frames - frames // 2)
    chosen = np.concatenate([rng.choice(rows, count, replace=False) for rows, count in halves])
    return Motion(face.id, np.round(modes[np.sort(chosen)] / face.std, 3))


def read_motion(path: Path = SHIPPED) -> Motion:
    """Read a motion sample: a CSV whose header is the face's id and the modes. Raises RigError."""
    try:
        rows = read_rows(path)
        cells = [[parse_cell(cell, "a mode") for cell in row] for row in rows[1:]]
        values = np.array(cells, np.float64)
        if len(cells) == 0 or values.shape != (len(cells), len(rows[0])):
            raise DecodeError("its rows are not all as long as its header")
    except (OSError, ValueError) as error:
        raise RigError(
            f"{path}: is not a motion sample ({error}); rebuild it: python scripts/fit_rig.py"
        ) from error
    return Motion(rows[0][0].removeprefix("face "), values[:, 1:])


def write_motion(path: Path, motion: Motion) -> None:
    """Write a motion sample atomically."""
    modes = [f"mode{k + 1}" for k in range(motion.standardized.shape[1])]
    lines = [",".join([f"face {motion.face}", *modes])]
    lines += [
        ",".join([str(row), *(f"{value:.3f}" for value in values)])
        for row, values in enumerate(motion.standardized, start=1)
    ]
    write_text(path, "\n".join(lines) + "\n")


CLOSED_APERTURE = 0.6  # mm: tracked lips that touch are this far apart or less


def closed_face(face: FaceModel, modes: Array) -> Array:
    """The mean face of the frames with closed lips, (frames, m) -> (landmarks, 3) mm."""
    shut = lip_aperture(face.instance(modes), face) < CLOSED_APERTURE
    return np.asarray(face.instance(modes[shut].mean(axis=0, keepdims=True))[0])
