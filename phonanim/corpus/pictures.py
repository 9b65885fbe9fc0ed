"""Recordings with mouth videos -> an appearance model and the joint modes of every frame."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError, read_tensors
from phonanim.core.files import atomic_path
from phonanim.corpus.corpus import Corpus, load_corpus, read_clips, read_landmarks
from phonanim.corpus.examples import make_examples
from phonanim.errors import CorpusError
from phonanim.face.appearance import (
    LUMA,
    AppearanceModel,
    Texture,
    appearance_mesh,
    fit_region,
    inner_mouth,
    joint_weight,
    load_appearance,
    principal,
    save_appearance,
    without_light,
)
from phonanim.face.fit import fit_face
from phonanim.face.model import FaceModel
from phonanim.face.warp import Mesh
from phonanim.media.video import read_clip
from phonanim.regressors import Examples

Array = NDArray[np.float64]
Progress = Callable[[float], None]

FOLDER = "appearance"  # in the corpus folder
SAMPLES = 4000  # approximate number of frames for the PCA
FIRST_PASS = 0.2  # share of the progress


@dataclass(frozen=True)
class Settings:
    """The share of the variance that each part keeps, and the size of a texture's pixels in mm.

    The last components of the outer region are camera noise and video compression.
    """

    outer: float = 0.8
    inner: float = 0.95
    joint: float = 0.98
    pixel: float = 1.25


@dataclass(frozen=True)
class MouthFilms:
    """Mouth videos with the landmarks (frames, landmarks, 2) in pixels of each video."""

    folder: Path
    corpus: Corpus
    landmarks: NDArray[np.float32]

    def film(self, clip: int) -> NDArray[np.uint8]:
        """The frames of one clip, (frames, rows, columns, 3). Raises CorpusError."""
        path = self.folder / "mouth" / f"{self.corpus.clips[clip]}.mp4"
        if not path.is_file():
            raise CorpusError(f"{path}: not found; the appearance model needs a mouth video of every clip")
        frames = read_clip(path)
        if len(frames) != self.corpus.frames[clip]:
            raise CorpusError(
                f"{path}: has {len(frames)} frames and {self.corpus.frames[clip]} landmarks; film it again"
            )
        return frames

    def cut(
        self, clip: int, face: FaceModel, rows: NDArray[np.int64], mesh: Mesh, step: int = 1
    ) -> tuple[Array, Texture]:
        """Shape modes (frames, m) and textures (frames, p, 3) of every `step`-th frame of one clip."""
        at = self.corpus.rows([clip])[::step]
        textures = mesh.cut(self.film(clip)[::step], self.landmarks[at][:, rows])
        return face.project(self.corpus.landmarks[at]), textures


@dataclass(frozen=True)
class Captured:
    """The filmed appearance of a corpus: `joint` (frames, j) of all its frames, and pixels for scoring.

    `grey` (n, p) are the captured textures of the corpus rows `rows` (n,), its test clips, in grey levels
    0 to 255 and in mean light.
    """

    model: AppearanceModel
    joint: NDArray[np.float32]
    grey: NDArray[np.float16]
    rows: NDArray[np.int64]


@dataclass(frozen=True)
class PixelError:
    """Mean squared errors of each frame, (frames,) in grey levels squared: all pixels and the two regions."""

    whole: Array
    inner: Array
    outer: Array


def open_mouth_films(folder: Path, corpus: Corpus) -> MouthFilms:
    """The videos that a corpus was built from. Raises CorpusError when the folder has other videos."""
    rows = read_clips(folder)
    if tuple(row["clip"] for row in rows) != corpus.clips:
        raise CorpusError(f"{folder}: its clips are not those of the corpus; build the corpus from it first")
    if "crop_x" not in rows[0] or "crop_y" not in rows[0]:
        raise CorpusError(
            f"{folder / 'clips.csv'}: lacks crop_x and crop_y, the position of the mouth videos in the image"
        )
    crops = np.array([[float(row["crop_x"]), float(row["crop_y"])] for row in rows])
    pixels = read_landmarks(folder, rows)[0][:, :, :2] * np.array([1.0, -1.0])
    return MouthFilms(
        folder, corpus, (pixels - np.repeat(crops, corpus.frames, axis=0)[:, None]).astype("f4")
    )


def build_appearance(
    recordings: Path,
    destination: Path,
    settings: Settings = Settings(),
    progress: Progress = lambda done: None,
) -> Captured:
    """Fit the appearance model of a corpus to its recordings and write it into the corpus folder.

    Only training clips are used for the fit; every clip is projected. Raises CorpusError.
    """
    corpus = load_corpus(destination)
    films = open_mouth_films(recordings, corpus)
    face = fit_face(corpus.landmarks[corpus.rows(corpus.clips_of("train"))], corpus.indices)
    model = fit_appearance(films, face, settings, lambda done: progress(FIRST_PASS * done))
    captured = capture_joint_modes(films, model, lambda done: progress(FIRST_PASS + (1 - FIRST_PASS) * done))
    save_captured(captured, destination, corpus)
    return captured


def fit_appearance(
    films: MouthFilms, face: FaceModel, settings: Settings, progress: Progress = lambda done: None
) -> AppearanceModel:
    """The appearance model of a corpus' training clips, fitted to about SAMPLES of their frames."""
    rows, mesh = appearance_mesh(face, settings.pixel)
    clips, step = choose_samples(films.corpus)
    pieces = []
    for done, clip in enumerate(clips, 1):
        pieces.append(films.cut(int(clip), face, rows, mesh, step))
        progress(done / len(clips))
    return fit_model(pieces, face, rows, mesh, settings)


def fit_model(
    pieces: list[tuple[Array, Texture]],
    face: FaceModel,
    rows: NDArray[np.int64],
    mesh: Mesh,
    settings: Settings,
) -> AppearanceModel:
    """The model of clips given as shape modes (frames, m) and textures (frames, p, 3)."""
    slopes = texture_slopes(pieces)
    mean = np.mean([textures.mean(axis=0) for _, textures in pieces], axis=0)
    shape = np.concatenate([parameters for parameters, _ in pieces])
    textures = np.concatenate([without_light(piece, modes, mean, slopes) for modes, piece in pieces])
    inside = inner_mouth(face, rows, mesh)
    outer = fit_region(textures, np.flatnonzero(~inside), settings.outer)
    inner = fit_region(textures, np.flatnonzero(inside), settings.inner)
    weight = joint_weight(face, outer, inner)
    parts = np.concatenate([weight * shape, outer.project(textures), inner.project(textures)], axis=1)
    basis, std = principal(parts, settings.joint)
    return AppearanceModel(face, rows, mesh, outer, inner, slopes, weight, basis, std, settings.pixel)


def choose_samples(corpus: Corpus) -> tuple[NDArray[np.int64], int]:
    """Training clips, and a frame step that leaves about SAMPLES frames."""
    clips = corpus.clips_of("train")
    surplus = max(1.0, float(corpus.frames[clips].sum()) / SAMPLES)
    skip = min(int(np.sqrt(surplus)), len(clips))
    return clips[::skip], max(1, round(surplus / skip))


def texture_slopes(pieces: list[tuple[Array, Texture]]) -> Texture:
    """How textures change with the shape within clips, by least squares: -> (m, p, 3) levels per mm."""
    shape = np.concatenate([modes - modes.mean(axis=0) for modes, _ in pieces])
    moments = sum(
        np.tensordot((modes - modes.mean(axis=0)).astype(np.float32), textures, (0, 0))
        for modes, textures in pieces
    )
    moments = np.asarray(moments, np.float64)
    solved = np.linalg.lstsq(shape.T @ shape, moments.reshape(len(moments), -1), rcond=None)[0]
    return np.asarray(solved.reshape(moments.shape), np.float32)


def capture_joint_modes(
    films: MouthFilms, model: AppearanceModel, progress: Progress = lambda done: None
) -> Captured:
    """The joint modes of every frame, and the grey textures of the test clips."""
    corpus = films.corpus
    joint = np.empty((int(corpus.frames.sum()), len(model.std)), np.float32)
    grey = []
    for clip in range(len(corpus.clips)):
        modes, textures = films.cut(clip, model.face, model.rows, model.mesh)
        textures = model.without_light(textures, modes)
        joint[corpus.rows([clip])] = model.project(modes, textures)
        if corpus.split[clip] == "test":
            grey.append((textures @ LUMA).astype(np.float16))
        progress((clip + 1) / len(corpus.clips))
    rows = corpus.rows(corpus.clips_of("test")) if grey else np.empty(0, np.int64)
    pixels = np.concatenate(grey) if grey else np.empty((0, len(model.mesh.pixels)), np.float16)
    return Captured(model, joint, pixels, rows)


def joint_examples(corpus: Corpus, captured: Captured, clips: Iterable[int]) -> Examples:
    """Clips of a corpus as training examples whose targets are joint modes, (frames, j)."""
    chosen = [int(clip) for clip in clips]
    targets = tuple(captured.joint[corpus.rows([clip])] for clip in chosen)
    return replace(make_examples(corpus, captured.model.face, chosen), targets=targets)


def save_captured(captured: Captured, destination: Path, corpus: Corpus) -> None:
    """Write a model and the captured data of a corpus into the folder `appearance` of the corpus."""
    from safetensors.numpy import save

    folder = destination / FOLDER
    card = {"corpus": corpus.provenance, "bound": reconstruction_error(captured)}
    save_appearance(captured.model, folder, card)
    with atomic_path(folder / "captured.safetensors") as path:
        path.write_bytes(save({"joint": captured.joint, "grey": captured.grey, "rows": captured.rows}))


def load_captured(destination: Path) -> Captured:
    """Read the output of `build_appearance` from a corpus folder. Raises ModelError or CorpusError."""
    folder = destination / FOLDER
    model = load_appearance(folder)
    try:
        stored = read_tensors(folder / "captured.safetensors")
        return Captured(model, stored["joint"], stored["grey"], stored["rows"])
    except (OSError, KeyError, DecodeError) as error:
        raise CorpusError(
            f"{folder}: is damaged ({error}); make it again with `phonanim corpus appearance`"
        ) from error


def pixel_mse(model: AppearanceModel, joint: NDArray[np.floating], grey: NDArray[np.floating]) -> PixelError:
    """Mean squared difference of rendered and captured pixels of each frame, in grey levels squared.

    `joint` (frames, j) are predicted, `grey` (frames, p) captured (`Captured.grey`). Measured in the
    reference shape, so that a wrong shape is not counted twice (Taylor 2017, section 8.2).
    """
    predicted = model.instance(joint)[1] @ LUMA
    squared = (predicted - grey.astype(np.float32)) ** 2
    return PixelError(
        np.asarray(squared.mean(axis=1), np.float64),
        np.asarray(squared[:, model.inner.place].mean(axis=1), np.float64),
        np.asarray(squared[:, model.outer.place].mean(axis=1), np.float64),
    )


def reconstruction_error(captured: Captured) -> dict[str, float]:
    """The pixel error of the model itself on the test clips, a lower bound for every prediction."""
    if len(captured.rows) == 0:
        return {}
    error = pixel_mse(captured.model, captured.joint[captured.rows], captured.grey)
    return {name: round(float(getattr(error, name).mean()), 3) for name in ("whole", "inner", "outer")}
