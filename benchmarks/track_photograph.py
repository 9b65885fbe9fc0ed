"""How well a real face is tracked whose motion is known: a photograph is moved, turned and warped.

    pip install scikit-image                        (a photograph of a face: skimage/data/astronaut.png)
    python benchmarks/track_photograph.py astronaut.png -o work/track_photograph.json

Needs `phonanim[track]`, scipy and Pillow. The landmarks of the photograph itself are found by the tracker;
from then on the truth is what was done to them. Errors are of MediaPipe, of the coding, and of stabilization.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

from phonanim.corpus.corpus import PUPIL_DISTANCE_MM, PUPILS, stabilize
from phonanim.corpus.tracking import Tracker, measure_quality, mediapipe_tracker, shipped_indices, track_film
from phonanim.errors import CorpusError
from phonanim.face.warp import Mesh, build_mesh
from phonanim.media.video import Frame, open_film, write_film

Array = NDArray[np.float64]

ROWS, COLUMNS, RATE, FRAMES = 480, 640, 25, 100
PUPILS_PX = 70.0  # of the face in the film
LIPS = (13, 14)  # the inner rims, above and below
CHIN = 152


@dataclass(frozen=True)
class Motion:
    """What is done to the photograph at most in one swing: pixels, degrees, shares, millimetres."""

    right: float = 0
    down: float = 0
    roll: float = 0
    zoom: float = 0
    light: float = 0
    blur: float = 0
    opening: float = 0


MOTIONS = {
    "still": Motion(),
    "moved by 80 px": Motion(right=80, down=20),
    "rolled by 20 degrees": Motion(roll=20),
    "nearer and farther by 25 %": Motion(zoom=0.25),
    "light from 0.4 to 1.6": Motion(light=0.6),
    "blurred by 3 px": Motion(blur=3),
    "mouth opened by 12 mm": Motion(opening=12),
    "all of these, half": Motion(40, 10, 10, 0.12, 0.3, 1.5, 12),
    "leaves the picture": Motion(down=200),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("photograph", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    tracker = mediapipe_tracker(shipped_indices())
    photograph, points = framed(Image.open(options.photograph).convert("RGB"), tracker)
    results = {name: measure(motion, photograph, points, tracker) for name, motion in MOTIONS.items()}
    options.output.write_text(json.dumps(results, indent=1) + "\n")
    for name, result in results.items():
        print(f"{name:28}", ", ".join(f"{key} {value}" for key, value in result.items()))


def framed(picture: Image.Image, tracker: Tracker) -> tuple[Frame, Array]:
    """The photograph with the face in the middle of a frame and PUPILS_PX wide, and its landmarks there."""
    points = _found(np.asarray(picture), tracker)
    right, left = (points[_row(tracker, number), :2] for number in PUPILS)
    scale = float(np.linalg.norm(left - right)) / PUPILS_PX
    corner = (right + left) / 2 - scale * np.array([COLUMNS, ROWS]) / 2
    data = (scale, 0, corner[0], 0, scale, corner[1])
    frame = np.asarray(
        picture.transform((COLUMNS, ROWS), Image.Transform.AFFINE, data, Image.Resampling.BICUBIC)
    )
    return frame, _found(frame, tracker)


def _found(picture: Frame, tracker: Tracker) -> Array:
    """Landmarks after some frames of the same picture: the tracker settles."""
    points = list(tracker.follow([picture] * 10))[-1]
    if points is None:
        raise SystemExit("no face was found in the photograph")
    return points


def measure(motion: Motion, photograph: Frame, points: Array, tracker: Tracker) -> dict[str, float | str]:
    """Film the photograph in motion, track it, and compare with what was done."""
    mesh = build_mesh(points[:, :2])
    phases = np.arange(FRAMES) / FRAMES
    with TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        write_film(filmed(motion, photograph, points, mesh, tracker), path, Fraction(RATE))
        film, started = open_film(path), time.process_time()
        try:
            landmarks = track_film(film, tracker).landmarks
        except CorpusError as error:
            return {"refused": str(error).removeprefix(f"{path}: ")}
    seconds = time.process_time() - started
    truth = np.stack([moved(motion, phase, shape_at(motion, phase, points, tracker)) for phase in phases])
    return compared(landmarks, truth, motion, tracker) | {"cpu ms a frame": round(seconds / FRAMES * 1000, 1)}


def compared(landmarks: Array, truth: Array, motion: Motion, tracker: Tracker) -> dict[str, float | str]:
    """Errors in pixels of the film; and in mm, after stabilization, of a still or opening mouth."""
    every = np.ones(len(landmarks), bool)
    shapes, opened = (stabilize(shape, tracker.indices, every)[0][..., :2] for shape in (landmarks, truth))
    drift = shapes - shapes.mean(axis=0) - (opened - opened.mean(axis=0))
    off = (landmarks - truth)[..., :2]
    above, below = (_row(tracker, number) for number in LIPS)
    gaps = [shape[:, below, 1] - shape[:, above, 1] for shape in (shapes, opened)]
    result: dict[str, float | str] = {
        "error px": _rms(off),
        "moves after stabilization mm": _rms(drift),
        "largest mm": round(float(np.linalg.norm(drift, axis=2).max()), 2),
        "lips mm": _rms(drift[:, [above, below]]),
        "jitter mm": round(measure_quality(landmarks, tracker.indices).jitter_mm, 2),
    }
    if motion.opening:
        slope, _ = np.polyfit(gaps[1], gaps[0], 1)
        result |= {"opening r": round(float(np.corrcoef(*gaps)[0, 1]), 3), "slope": round(float(slope), 2)}
    return result


def filmed(motion: Motion, photograph: Frame, points: Array, mesh: Mesh, tracker: Tracker) -> Iterator[Frame]:
    """The frames: the mouth is warped open, then the picture moved, blurred and lit."""
    texture = mesh.cut(photograph[None], points[None, :, :2])[0]
    for number in range(FRAMES):
        phase = number / FRAMES
        shape = shape_at(motion, phase, points, tracker)
        frame = mesh.draw(texture, shape[:, :2], photograph) if motion.opening else photograph
        matrix, shift = similarity(motion, phase)
        back = np.linalg.inv(matrix)
        data = np.column_stack([back, -back @ shift]).ravel()
        picture = Image.fromarray(frame).transform(
            (COLUMNS, ROWS), Image.Transform.AFFINE, tuple(data), Image.Resampling.BICUBIC
        )
        blurred = picture.filter(ImageFilter.GaussianBlur(motion.blur * _wave(phase) ** 2))
        lit = np.asarray(blurred, float) * (1 + motion.light * _wave(phase))
        yield np.clip(np.rint(lit), 0, 255).astype(np.uint8)


def shape_at(motion: Motion, phase: float, points: Array, tracker: Tracker) -> Array:
    """The photograph's landmarks with the jaw down: all below the inner lips, less towards the cheeks."""
    right, left = (points[_row(tracker, number)] for number in PUPILS)
    amount = (
        motion.opening
        * np.linalg.norm(left - right)
        / PUPIL_DISTANCE_MM
        * (0.5 - 0.5 * np.cos(6 * np.pi * phase))
    )
    above, below = (points[_row(tracker, number), 1] for number in LIPS)
    chin = points[_row(tracker, CHIN), 1]
    middle = (above + below) / 2
    lower = (points[:, 1] > middle) & (np.arange(len(points)) != _row(tracker, LIPS[0]))
    across = (points[:, 0] - points[_row(tracker, LIPS[1]), 0]) / (chin - middle)
    share = np.where(lower, np.exp(-2 * across**2), 0)
    return points + np.column_stack([np.zeros_like(share), amount * share, np.zeros_like(share)])


def moved(motion: Motion, phase: float, points: Array) -> Array:
    """Landmarks where the similarity puts them."""
    matrix, shift = similarity(motion, phase)
    depth = points[:, 2] * np.sqrt(np.linalg.det(matrix))
    return np.column_stack([points[:, :2] @ matrix.T + shift, depth])


def similarity(motion: Motion, phase: float) -> tuple[Array, Array]:
    """Matrix and shift of a phase: turned and scaled about the middle of the frame."""
    angle, scale = np.radians(motion.roll * _wave(phase)), 1 + motion.zoom * _wave(phase)
    matrix = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    middle = np.array([COLUMNS, ROWS]) / 2
    return matrix, middle - matrix @ middle + np.array([motion.right, motion.down]) * _wave(phase)


def _wave(phase: float) -> float:
    return float(np.sin(2 * np.pi * phase))


def _row(tracker: Tracker, number: int) -> int:
    return int(np.flatnonzero(tracker.indices == number)[0])


def _rms(off: Array) -> float:
    return round(float(np.sqrt((off**2).sum(axis=-1).mean())), 2)


if __name__ == "__main__":
    main()
