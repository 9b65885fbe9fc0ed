"""A small made-up speaker with a picture: the shipped head's landmarks and smooth random skin."""

from __future__ import annotations

from functools import cache

import numpy as np
from faces import head_face

from phonanim.corpus.pictures import Settings, fit_model
from phonanim.face.aam import Fitter, Pose
from phonanim.face.appearance import LUMA, AppearanceModel, appearance_mesh, reference_shape

PIXEL = 2.5  # mm


def skin(rng: np.random.Generator, height: int, width: int) -> np.ndarray:
    """A picture of soft blobs in three channels, (height, width, 3) 40 to 215."""
    spectrum = np.fft.rfft2(rng.normal(size=(3, height, width)))
    down, right = np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None]
    smooth = np.fft.irfft2(spectrum * np.exp(-(down**2 + right**2) / 0.02), (height, width))
    smooth /= np.abs(smooth).max()
    return (127 + 88 * smooth.transpose(1, 2, 0)).astype(np.float32)


@cache
def pictured_face() -> AppearanceModel:
    """An appearance model of 8 clips of 15 frames, in which two patterns come and go."""
    rng = np.random.default_rng(5)
    face = head_face()
    rows, mesh = appearance_mesh(face, PIXEL)
    base, *patterns = (skin(rng, mesh.height, mesh.width).reshape(-1, 3)[mesh.pixels] for _ in range(5))
    pieces = []
    for _ in range(8):
        modes = rng.normal(size=(15, len(face.std))) * face.std
        amounts = rng.normal(0, 0.1, (15, 4)).astype(np.float32)
        varied = base + np.tensordot(amounts, np.stack(patterns) - 127, 1)
        pieces.append((modes, varied.astype(np.float32)))
    return fit_model(pieces, face, rows, mesh, Settings(outer=0.99, inner=0.99, joint=0.999, pixel=PIXEL))


def texture_points(model: AppearanceModel, scale: float = 1.0) -> np.ndarray:
    """The mesh's landmarks of the reference shape, centred, (n, 2) pixels."""
    flat = reference_shape(model.face)[model.rows, :2] * np.array([1.0, -1.0]) / model.pixel * scale
    return flat - flat.mean(axis=0)


def a_pose(fitter: Fitter, seed: int = 3, scale: float = 1.3) -> Pose:
    """A face of random modes, turned a little, near the middle of 150 x 110 pixels."""
    rng = np.random.default_rng(seed)
    return Pose(np.array([scale, 0.04, 70.0, 55.0]), rng.normal(0, 0.7, len(fitter.start)))


def photograph(fitter: Fitter, pose: Pose) -> np.ndarray:
    """A grey picture of the face in a pose before a patterned wall."""
    wall = skin(np.random.default_rng(9), 110, 150).astype(np.uint8)
    drawn = fitter.model.mesh.draw(fitter.model.mean_texture, fitter.points(pose), wall)
    return drawn.astype(np.float32) @ LUMA
