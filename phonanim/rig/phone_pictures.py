"""Draw a rig's own head at single phones beside the shipped head, from the front and from the side."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation import articulate
from phonanim.face.model import MOUTH_CORNER_LEFT, MOUTH_CORNER_RIGHT, FaceModel
from phonanim.media.pixels import Image, draw_text, write_png
from phonanim.metrics.phones import phone_middles
from phonanim.rig.fit_quality import probe
from phonanim.rig.head import Head, load_head
from phonanim.rig.landmark_rig import to_face_axes
from phonanim.rig.landmarks import MeshLandmarks, shipped_landmarks
from phonanim.rig.pronounce import pronounce
from phonanim.rig.read import load_rig
from phonanim.rig.render import View, render
from phonanim.rig.rig import Rig

PHONES = ("aa", "iy", "uw", "w", "sh", "f", "m")
YAWS, SIZE, CLOSE, CAPTION, MARGIN = (
    (0.0, 50.0),
    190,
    1.35,
    26,
    84,
)  # degrees, pixels, of the eyes' height above
PAPER, INK = (250, 250, 250), (20, 20, 20)


def draw_phones(path: Path, rig: Rig, head: Head, landmarks: MeshLandmarks, face: FaceModel) -> None:
    """Draw the middle of each of PHONES in the probe sentences, and write a PNG. Raises OutputError."""
    columns = np.full((CAPTION, MARGIN + SIZE * len(PHONES), 3), PAPER, np.uint8)
    for number, phone in enumerate(PHONES):
        draw_text(columns, phone.upper(), MARGIN + number * SIZE + SIZE // 2, 4, INK, "large", align=0.5)
    shipped = load_rig("arkit")
    rows = [columns]
    for yaw in YAWS:
        rows.append(_row(rig.name, rig, head, landmarks, face, yaw))
        rows.append(_row("shipped", shipped, load_head(), shipped_landmarks(), face, yaw))
    write_png(np.vstack(rows), path)


def _row(name: str, rig: Rig, head: Head, landmarks: MeshLandmarks, face: FaceModel, yaw: float) -> Image:
    straight = to_face_axes(head, landmarks, face)
    metres = replace(straight, vertices=straight.vertices / 1000, deltas=straight.deltas / 1000)
    mouth = landmarks.take((MOUTH_CORNER_RIGHT, MOUTH_CORNER_LEFT)).of(metres.vertices).mean(axis=0)
    view = View((0.0, float(mouth[1]), float(mouth[2])), CLOSE * float(-mouth[1]), SIZE, SIZE, yaw)
    margin = np.full((SIZE, MARGIN, 3), PAPER, np.uint8)
    draw_text(margin, name[:12], MARGIN // 2, SIZE // 2 - 8, INK, align=0.5)
    shapes = metres.shape(metres.weights(_controls(rig), rig.controls))
    return np.hstack([margin, *(render(shape, metres, view) for shape in shapes)])


def _controls(rig: Rig) -> NDArray[np.float32]:
    """A rig's controls in the middle of the first of each phone, (phones, controls)."""
    track, times = probe()
    assert rig.mouth is not None
    middles = [phone_middles(track, (phone,))[0] for phone in PHONES]
    frames = np.searchsorted(times, middles)
    return pronounce(articulate(track, times), rig, rig.mouth)[frames]
