"""Track the speaking face in videos: landmarks frame by frame, and their quality."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import tee
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.stderr import silent_stderr
from phonanim.corpus.corpus import PUPIL_DISTANCE_MM, PUPILS, RIGID
from phonanim.errors import CorpusError, MissingExtraError
from phonanim.face.model import OUTER_LIPS
from phonanim.media.video import Film, Frame, read_frames

Array = NDArray[np.float64]

LONGEST_GAP = 0.12  # seconds without a face that are interpolated linearly
LARGEST_JUMP = 0.25  # of the pupil distance; a head moves a tenth of that in a frame of 1/25 s
SMALL_FACE = 40.0  # pixels between the pupils; below, a tracker's noise is as large as small lip movements
TURNED = 20.0  # degrees

Follow = Callable[[Iterable[Frame]], Iterator[Array | None]]


@dataclass(frozen=True)
class Tracker:
    """A way to find a face: `follow` gives every frame's landmarks, or None without a face.

    Landmarks are (landmarks, 3) pixels: right, down, and away from the camera. `indices` (landmarks,)
    are MediaPipe face-mesh numbers; `miss` is the reason for None, in words.
    """

    name: str
    indices: NDArray[np.int64]
    follow: Follow
    miss: str


@dataclass(frozen=True)
class Track:
    """A face in a video: `landmarks` (frames, landmarks, 3) pixels; `rejected` frames with the reasons."""

    landmarks: Array
    rejected: dict[int, str]


@dataclass(frozen=True)
class Quality:
    """Quality of a track: pixels between the pupils, jitter and turn of the head (largest, degrees).

    `jitter_mm` is the standard deviation of white noise with the same second differences as the rigid
    landmarks, which speech does not move. It is the noise of the tracker plus a little head motion.
    """

    pupils_px: float
    jitter_mm: float
    turn_deg: float

    def warnings(self) -> list[str]:
        """Warnings about the track, one sentence each."""
        small = f"the face is small ({self.pupils_px:.0f} px between the pupils): film it closer"
        turned = f"the head turns by {self.turn_deg:.0f} degrees: look into the camera"
        return [small] * (self.pupils_px < SMALL_FACE) + [turned] * (self.turn_deg > TURNED)


def shipped_indices() -> NDArray[np.int64]:
    """The landmarks of the package's reference face, so that corpora can be compared."""
    from phonanim.core.catalog import DEFAULT_MODEL, SHIPPED
    from phonanim.regressors import load_face

    return load_face(SHIPPED / DEFAULT_MODEL / "face.safetensors").indices


def mediapipe_tracker(indices: NDArray[np.int64]) -> Tracker:
    """MediaPipe's face mesh with its iris (Kartynnik et al. 2019). Raises MissingExtraError."""
    try:
        from mediapipe.python.solutions import face_mesh
    except ImportError as error:
        raise MissingExtraError(
            "tracking needs MediaPipe: pip install 'phonanim[track]', in a separate environment "
            "(it needs numpy below 2); or --model with an appearance model of this speaker"
        ) from error

    def follow(frames: Iterable[Frame]) -> Iterator[Array | None]:
        with silent_stderr():
            mesh = face_mesh.FaceMesh(max_num_faces=1, refine_landmarks=True)
            mesh.process(np.zeros((64, 64, 3), np.uint8))  # its threads print messages when they start
        with mesh:
            for frame in frames:
                with silent_stderr():
                    faces = mesh.process(np.ascontiguousarray(frame)).multi_face_landmarks
                yield _pixels(faces[0], frame, indices) if faces else None

    return Tracker("mediapipe", indices, follow, "no face was found")


def _pixels(face: Any, frame: Frame, indices: NDArray[np.int64]) -> Array:
    """MediaPipe's coordinates, shares of the picture's sides, in pixels; depth is in shares of the width."""
    rows, columns = frame.shape[:2]
    points = np.array([[face.landmark[i].x, face.landmark[i].y, face.landmark[i].z] for i in indices])
    return points * [columns, rows, columns]


def aam_tracker(folder: Path) -> Tracker:
    """A search for the face of an appearance model. Raises ModelError."""
    from phonanim.face.aam import build_fitter, track_face
    from phonanim.face.appearance import load_appearance

    model = load_appearance(folder)
    fitter = build_fitter(model)

    def follow(frames: Iterable[Frame]) -> Iterator[Array | None]:
        for pose in track_face(fitter, frames):
            yield fitter.landmarks(pose) if pose else None

    likeness = f"the model explains less than {fitter.options.likeness:.0%} of the picture"
    return Tracker("aam", model.face.indices, follow, likeness)


def track_film(film: Film, tracker: Tracker, progress: Callable[[float], None] = lambda done: None) -> Track:
    """Track the face through a video; short gaps are interpolated.

    A frame in which the face jumps, or its mouth leaves the picture, is rejected like a frame without a face.
    Raises CorpusError when no frame has a face, when a gap is longer than LONGEST_GAP, or when the face
    continues at another place.
    """
    found: list[Array | None] = []
    rejected: dict[int, str] = {}
    followed, seen = tee(read_frames(film.path))
    for number, (points, frame) in enumerate(zip(tracker.follow(followed), seen, strict=True)):
        found.append(points)
        if points is None:
            rejected[number] = tracker.miss
        elif leaves_frame(points, tracker.indices, frame):
            rejected[number] = "the mouth leaves the picture"
        progress(min(1.0, (number + 1) / film.frames))
    if len(rejected) == len(found):
        why = rejected[0]
        raise CorpusError(f"{film.path}: {why} in any frame; the whole face must be visible from the front")
    blank = np.full((len(tracker.indices), 3), np.nan)
    landmarks = np.stack([blank if points is None else points for points in found])
    landmarks[list(rejected)] = np.nan
    rejected |= dict.fromkeys(find_jumps(landmarks, tracker.indices, float(film.rate)), "the face jumped")
    landmarks[list(rejected)] = np.nan
    check_gaps(film, rejected)
    check_cuts(film, landmarks, tracker.indices)
    return Track(bridge_gaps(landmarks), dict(sorted(rejected.items())))


def find_jumps(landmarks: Array, indices: NDArray[np.int64], rate: float) -> list[int]:
    """Frames whose rigid landmarks are far from those before and after, although these agree."""
    steps, allowed = _steps(landmarks, indices, rate)
    far = steps > allowed
    return [int(n) + 1 for n in np.flatnonzero(far[:-1] & far[1:])]


def check_cuts(film: Film, landmarks: Array, indices: NDArray[np.int64]) -> None:
    """Raise CorpusError when the face is at another place from one known frame to the next."""
    known = np.flatnonzero(np.isfinite(landmarks[:, 0, 0]))
    steps, allowed = _steps(landmarks[known], indices, float(film.rate))
    far = np.flatnonzero(steps > allowed * np.diff(known))
    if len(far):
        frame = int(known[far[0] + 1])
        raise CorpusError(
            f"{film.path}: the face is at another place from frame {frame} on, "
            f"{frame / float(film.rate):.2f} s (a cut, or a second person); cut the film there"
        )


def leaves_frame(points: Array, indices: NDArray[np.int64], frame: Frame) -> bool:
    """Whether a part of the lips is outside a frame."""
    lips = points[_rows(indices, OUTER_LIPS), :2]
    return bool((lips < 0).any() or (lips > [frame.shape[1], frame.shape[0]]).any())


def _steps(landmarks: Array, indices: NDArray[np.int64], rate: float) -> tuple[Array, float]:
    """Motion of the rigid landmarks from frame to frame, and the limit for a head, in pixels."""
    middle = landmarks[:, _rows(indices, RIGID), :2].mean(axis=1)
    allowed = LARGEST_JUMP * _pupils(landmarks, indices) * max(1.0, 25 / rate)
    return np.linalg.norm(np.diff(middle, axis=0), axis=1), allowed


def check_gaps(film: Film, rejected: Mapping[int, str]) -> None:
    """Raise CorpusError, which names the first run of rejected frames that is too long to interpolate."""
    frames = np.array(sorted(rejected), int)
    for run in np.split(frames, np.flatnonzero(np.diff(frames) > 1) + 1):
        if len(run) > LONGEST_GAP * float(film.rate):
            start = run[0] / float(film.rate)
            raise CorpusError(
                f"{film.path}: no usable face in frames {run[0]} to {run[-1]}, from {start:.2f} s "
                f"({rejected[int(run[0])]}); cut the film there"
            )


def bridge_gaps(landmarks: Array) -> Array:
    """Fill NaN frames from their neighbours: linear interpolation, constant at the ends."""
    flat = landmarks.reshape(len(landmarks), -1)
    known = np.flatnonzero(np.isfinite(flat).all(axis=1))
    at = np.arange(len(flat))
    return np.stack([np.interp(at, known, curve[known]) for curve in flat.T], axis=1).reshape(landmarks.shape)


def measure_quality(landmarks: Array, indices: NDArray[np.int64]) -> Quality:
    """Measure the quality of a track, (frames, landmarks, 3) pixels."""
    distance = _pupils(landmarks, indices)
    rigid = landmarks[:, _rows(indices, RIGID), :2]
    shaken = np.diff(rigid, n=2, axis=0) / np.sqrt(6) if len(rigid) > 2 else np.zeros((1, 1, 2))
    jitter = float(np.sqrt((shaken**2).sum(axis=2).mean())) * PUPIL_DISTANCE_MM / distance
    right, left = _rows(indices, PUPILS)
    across = landmarks[:, left] - landmarks[:, right]
    turn = np.degrees(np.arctan2(np.abs(across[:, 2]), np.abs(across[:, 0]))).max()
    return Quality(distance, jitter, float(turn))


def _pupils(landmarks: Array, indices: NDArray[np.int64]) -> float:
    right, left = _rows(indices, PUPILS)
    return float(np.nanmedian(np.linalg.norm(landmarks[:, left] - landmarks[:, right], axis=1)))


def _rows(indices: NDArray[np.int64], numbers: Iterable[int]) -> NDArray[np.int64]:
    return np.array([int(np.flatnonzero(indices == number)[0]) for number in numbers])
