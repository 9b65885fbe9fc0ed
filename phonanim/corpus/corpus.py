"""Recordings -> a training corpus: head-stabilized landmarks in millimetres with their phones."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import (
    DAMAGE,
    DecodeError,
    decode_part,
    decode_rate,
    read_arrays,
    read_json,
    read_tensors,
    read_utf8,
)
from phonanim.core.files import atomic_path
from phonanim.corpus.document import decode_corpus
from phonanim.corpus.motion import LANDMARKS, corpus_kind
from phonanim.errors import CorpusError
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.alignment import Interval
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack

MAX_CLIPS = 1 << 26  # bytes of clips.csv
PUPIL_DISTANCE_MM = 63.0
PUPILS = (468, 473)
# Nose bridge, eye corners and forehead, which speech does not move. It does move lids, brows and pupils.
RIGID = (6, 168, 8, 9, 10, 151, 133, 362, 33, 263, 195, 197, 5)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Corpus:
    """Clips, concatenated: `landmarks` (frames, landmarks, 3) float32 mm, and the speech of each clip.

    `indices` (landmarks,) are MediaPipe face-mesh numbers; `clips` are the names, `frames` (clips,) the
    lengths, `tracks` the phones, `words` the words, `split` "train" or "test", `audio` the paths of the
    recordings. Frame i of a clip was exposed around (i + 0.5) / fps seconds.
    """

    landmarks: NDArray[np.float32]
    indices: NDArray[np.int64]
    fps: float
    clips: tuple[str, ...]
    frames: NDArray[np.int64]
    tracks: tuple[PhoneTrack, ...]
    words: tuple[tuple[Interval, ...], ...]
    split: tuple[str, ...]
    audio: tuple[Path, ...]
    provenance: dict[str, Any]

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """First frame of each clip, (clips,)."""
        return np.concatenate([[0], np.cumsum(self.frames)[:-1]]).astype(np.int64)

    def rows(self, clips: Iterable[int]) -> NDArray[np.int64]:
        """Frame rows of some clips, in their order."""
        return np.concatenate([np.arange(self.starts[c], self.starts[c] + self.frames[c]) for c in clips])

    def clips_of(self, split: str) -> NDArray[np.int64]:
        """Numbers of the clips in a split."""
        return np.flatnonzero(np.array(self.split) == split)

    def times(self, clip: int) -> Array:
        """Mid-exposure instants of one clip, (frames,) seconds."""
        return np.asarray((np.arange(self.frames[clip]) + 0.5) / self.fps, np.float64)


def build_corpus(
    source: Path, destination: Path, progress: Callable[[float], None] = lambda done: None
) -> Corpus:
    """Read a recordings folder and write a training corpus.

    The folder has clips.csv (clip, frames, split), landmarks.npz (pixels, delta-coded),
    textgrid/*.TextGrid and audio/. Raises CorpusError, which names what is missing or inconsistent.
    """
    rows = read_clips(source)
    landmarks, indices, fps = read_landmarks(source, rows)
    progress(0.2)
    train = np.repeat([row["split"] == "train" for row in rows], [int(row["frames"]) for row in rows])
    frames = np.array([int(row["frames"]) for row in rows])
    shapes, pose = stabilize(landmarks, indices, train)
    shapes = remove_pose_leak(shapes, pose, frames, train)
    progress(0.6)
    tracks, words = [], []
    for row in rows:
        alignment = read_alignment(source / "textgrid" / f"{row['clip']}.TextGrid")
        tracks.append(to_phones(alignment, language="english")[0])
        words.append(tuple(word for word in alignment.words if word.label))
    progress(0.9)
    corpus = Corpus(
        landmarks=shapes.astype(np.float32),
        indices=indices,
        fps=fps,
        clips=tuple(row["clip"] for row in rows),
        frames=frames,
        tracks=tuple(tracks),
        words=tuple(words),
        split=tuple(row["split"] for row in rows),
        audio=tuple(source / "audio" / f"{row['clip']}.flac" for row in rows),
        provenance={"source": source.name, "rigid": list(RIGID), "pupil_distance_mm": PUPIL_DISTANCE_MM},
    )
    save_corpus(corpus, destination)
    progress(1.0)
    return corpus


def read_clips(source: Path) -> list[dict[str, str]]:
    """The rows of clips.csv: clip, frames, split. Raises CorpusError."""
    path = source / "clips.csv"
    if not path.is_file():
        raise CorpusError(f"{path}: not found; a recordings folder has clips.csv, landmarks.npz, textgrid/")
    try:
        rows = list(csv.DictReader(io.StringIO(read_utf8(path, MAX_CLIPS), newline="")))
    except (OSError, ValueError, csv.Error) as error:
        raise CorpusError(f"{path}: cannot be read as a table: {error}") from error
    if not rows or not {"clip", "frames", "split"} <= set(rows[0]):
        raise CorpusError(f"{path}: needs a row per clip with the columns clip, frames, split")
    for number, row in enumerate(rows, start=2):
        frames = row["frames"] or ""
        if not all(row[name] for name in ("clip", "split")) or not frames.isdecimal() or len(frames) > 9:
            raise CorpusError(f"{path} row {number}: needs a clip, a number of frames and a split")
        try:
            decode_part(row["clip"], "clip")
        except DecodeError as error:
            raise CorpusError(f"{path} row {number}: {error}") from error
    return rows


def read_landmarks(source: Path, rows: list[dict[str, str]]) -> tuple[Array, NDArray[np.int64], float]:
    """Tracked points (frames, landmarks, 3) in pixels, their numbers, and the rate. Raises CorpusError."""
    path = source / "landmarks.npz"
    if not path.is_file():
        raise CorpusError(f"{path}: not found; a recordings folder has clips.csv, landmarks.npz, textgrid/")
    try:
        stored = read_arrays(path)
        pixels = np.cumsum(stored["delta"].astype(np.int32), axis=0) * float(stored["scale"])
        indices, fps = stored["indices"].astype(np.int64), decode_rate(float(stored["fps"]))
        known = list(zip(stored["clips"].tolist(), stored["frames"].tolist(), strict=True))
        if pixels.shape != (sum(length for _, length in known), len(indices), 3):
            raise DecodeError(f"it has points of {pixels.shape}")
    except (OSError, *DAMAGE) as error:
        raise CorpusError(f"{path}: is damaged ({error}); track the clips again") from error
    if known != [(row["clip"], int(row["frames"])) for row in rows]:
        raise CorpusError(f"{path}: its clips and lengths differ from clips.csv; track the clips again")
    missing = sorted(set(RIGID + PUPILS) - set(indices.tolist()))
    if missing:
        raise CorpusError(f"{path}: lacks the landmarks {missing}, which are needed to stabilize the head")
    return pixels * np.array([1.0, -1.0, -1.0]), indices, fps  # y up, z towards the camera


def stabilize(points: Array, indices: NDArray[np.int64], train: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Remove the head's motion from landmarks, (frames, landmarks, 3) any unit -> the same in mm.

    Each frame is fitted by a similarity (rotation, translation, scale) on the RIGID landmarks to
    their mean over the training frames (generalized Procrustes, Umeyama 1991). Also returns the
    pose of each frame, (frames, 4): rotation vector in radians and log scale.
    """
    rigid = np.array([int(np.flatnonzero(indices == number)[0]) for number in RIGID])
    target = points[train][:, rigid].mean(axis=0)
    for _ in range(4):
        rotation, scale, centre = _similarity(points[:, rigid], target)
        aligned = np.einsum("nki,nij->nkj", points - centre[:, None], rotation) * scale[:, None, None]
        aligned += target.mean(axis=0)
        target = aligned[train][:, rigid].mean(axis=0)
    right, left = (int(np.flatnonzero(indices == number)[0]) for number in PUPILS)
    mean = aligned[train].mean(axis=0)
    millimetre = PUPIL_DISTANCE_MM / np.linalg.norm(mean[left] - mean[right])
    pose = np.column_stack([_rotation_vector(rotation), np.log(scale / scale[train].mean())])
    return (aligned - (mean[left] + mean[right]) / 2) * millimetre, pose


def _similarity(points: Array, target: Array) -> tuple[Array, Array, Array]:
    """Least-squares similarity of every frame to one target: R (n, 3, 3), scale (n,), centre (n, 3)."""
    centre = points.mean(axis=1)
    moved = points - centre[:, None]
    left, stretch, right = np.linalg.svd(np.einsum("nki,kj->nij", moved, target - target.mean(axis=0)))
    sign = np.sign(np.linalg.det(left @ right))
    left[:, :, 2] *= sign[:, None]
    stretch[:, 2] *= sign
    return left @ right, stretch.sum(axis=1) / (moved**2).sum(axis=(1, 2)), centre


def _rotation_vector(rotation: Array) -> Array:
    """Axis times angle of small rotations, (n, 3, 3) -> (n, 3) radians."""
    skew = np.stack(
        [
            rotation[:, 2, 1] - rotation[:, 1, 2],
            rotation[:, 0, 2] - rotation[:, 2, 0],
            rotation[:, 1, 0] - rotation[:, 0, 1],
        ],
        axis=1,
    )
    angle = np.arccos(np.clip((np.trace(rotation, axis1=1, axis2=2) - 1) / 2, -1, 1))
    return np.asarray(skew * (0.5 / np.maximum(np.sinc(angle / np.pi), 1e-9))[:, None])


def remove_pose_leak(
    shapes: Array, pose: Array, frames: NDArray[np.int64], train: NDArray[np.bool_]
) -> Array:
    """Subtract the error that the tracker makes for a turned head from stabilized shapes.

    A tracker bends the face a little with the head's pose, so a clip spoken with a lower chin gets another
    resting mouth. The clip means of the shapes are regressed on the clip means of the pose (linear, squared
    and yaw-by-pitch terms) over the training clips, and the fitted part is removed from all clips. Motion
    within a clip, and so speech, is not changed.
    """
    starts = np.concatenate([[0], np.cumsum(frames)[:-1]])
    terms = np.column_stack([pose, pose[:, :3] ** 2, pose[:, 0] * pose[:, 1]])
    design = np.add.reduceat(terms, starts, axis=0) / frames[:, None]
    design = np.column_stack([np.ones(len(design)), design])
    means = np.add.reduceat(shapes.reshape(len(shapes), -1), starts, axis=0) / frames[:, None]
    chosen = train[starts]
    weights = np.linalg.lstsq(design[chosen], means[chosen], rcond=None)[0]
    leak = design @ weights - shapes[train].mean(axis=0).ravel()
    return np.asarray(shapes - np.repeat(leak, frames, axis=0).reshape(shapes.shape))


def save_corpus(corpus: Corpus, folder: Path) -> None:
    """Write corpus.json and landmarks.safetensors into a folder, the index last."""
    from safetensors.numpy import save

    folder.mkdir(parents=True, exist_ok=True)
    with atomic_path(folder / "landmarks.safetensors") as path:
        path.write_bytes(save({"landmarks": corpus.landmarks, "indices": corpus.indices}))
    clips = [
        {
            "clip": name,
            "frames": int(corpus.frames[number]),
            "split": corpus.split[number],
            "audio": Path(os.path.relpath(corpus.audio[number], folder)).as_posix(),
            "words": [[word.label, word.start, word.end] for word in corpus.words[number]],
            "codes": corpus.tracks[number].codes.tolist(),
            "bounds": corpus.tracks[number].bounds.tolist(),
            "labels": list(corpus.tracks[number].labels),
        }
        for number, name in enumerate(corpus.clips)
    ]
    with atomic_path(folder / "corpus.json") as path:
        document = {"fps": corpus.fps, "provenance": corpus.provenance, "clips": clips}
        path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def load_corpus(folder: Path) -> Corpus:
    """Read a corpus that `build_corpus` wrote. Raises CorpusError when it is missing, damaged or no such."""
    try:
        document = read_json(folder / "corpus.json")
        arrays = read_tensors(folder / "landmarks.safetensors")
        return Corpus(**decode_corpus(document, arrays, folder))
    except (OSError, *DAMAGE) as error:
        kind = corpus_kind(folder)
        if kind not in ("", LANDMARKS):
            raise CorpusError(
                f"{folder}: is a corpus of {kind}, and landmarks are needed here; models of {kind} are "
                "scored by phonanim corpus score"
            ) from error
        raise CorpusError(
            f"{folder}: not a corpus ({error}); make one with `phonanim corpus build`"
        ) from error
