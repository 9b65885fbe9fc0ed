"""Draw a character in its poses, to check and to copy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.face.model import MOUTH_CORNER_LEFT, MOUTH_CORNER_RIGHT, FaceModel
from phonanim.media.pixels import Image, draw_text, paste, write_png
from phonanim.rig.head import Head
from phonanim.rig.landmark_rig import to_face_axes
from phonanim.rig.landmarks import MeshLandmarks
from phonanim.rig.render import View, render
from phonanim.rig.rig import MEAN, POSES, Rig

SIZE, MARGIN, CAPTION, COLUMNS = 240, 16, 44, 3  # pixels, pictures
PAPER, INK, FAINT = (24, 26, 31), (236, 238, 242), (142, 150, 163)
YAWS = (0.0, 40.0)  # degrees: from the front, and half from the side
CLOSE = 1.7  # height of a picture, in distances from eyes to mouth


def draw_poses(path: Path, rig: Rig, head: Head, landmarks: MeshLandmarks, face: FaceModel) -> None:
    """Draw the mean and the eight poses from two sides, named, and write a PNG. Raises OutputError."""
    straight = to_face_axes(head, landmarks, face)
    metres = replace(straight, vertices=straight.vertices / 1000, deltas=straight.deltas / 1000)
    weights = metres.weights(np.vstack([rig.mean, rig.poses]), rig.controls)
    named = {MEAN: "the reference face at its mean", **POSES}
    mouth = landmarks.take((MOUTH_CORNER_RIGHT, MOUTH_CORNER_LEFT)).of(metres.vertices).mean(axis=0)
    pictures = [_both_sides(metres, weight, mouth) for weight in weights]
    write_png(_composed(pictures, list(named.items())), path)


def _both_sides(head: Head, weights: NDArray[np.float64], mouth: NDArray[np.float64]) -> Image:
    span = CLOSE * float(-mouth[1])
    vertices = head.shape(weights)
    views = [View((0.0, float(mouth[1]), float(mouth[2])), span, SIZE, SIZE, yaw) for yaw in YAWS]
    return np.concatenate([render(vertices, head, view) for view in views], axis=1)


def _composed(pictures: list[Image], captions: list[tuple[str, str]]) -> Image:
    height, width = pictures[0].shape[0] + CAPTION + MARGIN, pictures[0].shape[1] + MARGIN
    rows = -(-len(pictures) // COLUMNS)
    image = np.full((rows * height + MARGIN, COLUMNS * width + MARGIN, 3), PAPER, np.uint8)
    for number, (picture, (pose, looks)) in enumerate(zip(pictures, captions, strict=True)):
        top, left = MARGIN + number // COLUMNS * height, MARGIN + number % COLUMNS * width
        paste(image, picture, left, top)
        draw_text(image, pose, left, top + SIZE + 4, INK)
        draw_text(image, looks, left, top + SIZE + 22, FAINT)
    return image
