"""What benchmarks/facediffuser.py measures: takes of clips that were not learned from, one for each seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.corpus.examples import make_examples
from phonanim.evaluation.statistics import bootstrap_interval, mean_rows
from phonanim.face.fit import fit_face
from phonanim.face.masks import landmark_masks
from phonanim.face.model import FaceModel, lip_aperture, lip_width
from phonanim.media.audio import read_sound
from phonanim.metrics import correlation, diversity, dynamics_deviation, vertex_error
from phonanim.regressors import Examples
from phonanim.regressors._diffusion import sample_motion
from phonanim.regressors._steps import (
    cached_encoder,
    features_at_steps,
    interpolate_rows,
    sound_features,
    step_times,
)
from phonanim.regressors.facediffuser import FaceDiffuser

TAKES = 5  # seeds that are compared
VARIANCE = 0.99  # of the whole face that its modes keep
LIPS = ("mouth", "jaw")  # how the names of controls begin that speech moves
UPPER = ("brow", "eye")
Floats = NDArray[np.float32]
Clips = NDArray[np.int64]


@dataclass(frozen=True)
class Judge:
    """The corpus, the clips that are learned from and those that are measured, and what may be predicted."""

    corpus: Corpus
    data: Path
    learned: Clips
    held_out: Clips

    @classmethod
    def of(cls, folder: Path, data: Path, seed: int = 0) -> Judge:
        """A tenth of the training clips is held out: as benchmarks/audio.py does, or recipes of a seed."""
        corpus = load_corpus(folder)
        shuffled = np.random.default_rng(seed).permutation(corpus.clips_of("train"))
        count = round(0.1 * len(shuffled))
        return cls(corpus, data, np.sort(shuffled[count:]), np.sort(shuffled[:count]))

    @cached_property
    def measured(self) -> Clips:
        """The held-out clips that are as long as most, so that they can be sampled side by side."""
        frames = self.corpus.frames[self.held_out]
        return self.held_out[frames == np.bincount(frames).argmax()]

    @cached_property
    def mouth(self) -> FaceModel:
        """The face of every regressor: what lies below the nose."""
        return fit_face(self.captured(self.corpus.clips_of("train")), self.corpus.indices)

    @cached_property
    def face(self) -> FaceModel:
        """Modes of all landmarks, so that lids, brows and cheeks take part."""
        return whole_face(self.captured(self.corpus.clips_of("train")), self.corpus.indices)

    @cached_property
    def scores(self) -> tuple[list[str], Floats]:
        """The names of ARKit's controls, and what the tracker gave each of them in every frame, 0 to 1."""
        with np.load(self.data / "blendshapes52.npz") as stored:
            if stored["clips"].tolist() != list(self.corpus.clips):
                raise click.ClickException(f"{self.data}: its clips are not those of the corpus")
            return stored["names"].tolist(), (stored["scores"] * stored["scale"]).astype(np.float32)

    def captured(self, clips: Clips) -> Floats:
        """Landmarks of clips end to end, (frames, landmarks, 3)."""
        return self.corpus.landmarks[self.corpus.rows(clips)]

    def examples(self, clips: Clips, targets: str) -> Examples:
        """Clips with their sound; targets are modes of the mouth or of the face, or controls of a rig."""
        if targets != "rig":
            return make_examples(self.corpus, getattr(self, targets), clips, with_sound=True)
        found = make_examples(self.corpus, self.mouth, clips, with_sound=True)
        return replace(found, targets=tuple(self.scores[1][self.corpus.rows([clip])] for clip in clips))


def whole_face(shapes: Floats, indices: NDArray[np.int64]) -> FaceModel:
    """Shape PCA of all landmarks, (frames, landmarks, 3) mm."""
    mean = shapes.mean(axis=0, dtype=np.float64)
    centred = (shapes - mean).reshape(len(shapes), -1)
    energy, vectors = np.linalg.eigh(centred.T @ centred / len(centred))
    energy, vectors = energy[::-1], vectors[:, ::-1].T
    count = int(np.searchsorted(np.cumsum(energy) / energy.sum(), VARIANCE)) + 1
    return FaceModel(mean, vectors[:count].reshape(count, *mean.shape), np.sqrt(energy[:count]), indices)


def takes_of(judge: Judge, model: FaceDiffuser, seeds: range) -> NDArray[np.floating]:
    """Held-out clips as a model speaks them, side by side: (takes, clips, frames, modes)."""
    sounds = [read_sound(judge.corpus.audio[clip]) for clip in judge.measured]
    grid = step_times(min(sound.duration for sound in sounds), model.config.rate)
    encoder = cached_encoder(model.config.encoder)
    values = [
        features_at_steps(sound_features(encoder, sound, None), grid, model.config.rate) for sound in sounds
    ]
    audio = model.embed_sound(np.stack([model.normalize_features(one) for one in values]))
    wide = (len(sounds), len(grid), len(model.low))
    place = (judge.corpus.times(int(judge.measured[0])) - grid[0]) * model.config.rate

    def take(seed: int) -> NDArray[np.floating]:
        def noise(turn: int) -> Floats:
            return np.random.default_rng([seed, turn]).standard_normal(wide, np.float32)

        found = model.unscale_modes(sample_motion(model.config, model.weights, audio, noise))
        return np.stack([interpolate_rows(one, place) for one in found])

    return np.stack([take(seed) for seed in seeds])


def measure_mouth(judge: Judge, model: FaceDiffuser) -> dict[str, Any]:
    """Errors of the lower face, and how far takes differ."""
    takes = takes_of(judge, model, range(TAKES if model.config.diffusion else 1))
    return lips(judge, judge.mouth, takes) | spread(judge, judge.mouth, takes)


def measure_face(judge: Judge, model: FaceDiffuser) -> dict[str, Any]:
    """The same of the whole face, and how lively its upper part is."""
    takes = takes_of(judge, model, range(TAKES if model.config.diffusion else 1))
    return lips(judge, judge.face, takes) | spread(judge, judge.face, takes) | lively(judge, takes)


def lips(judge: Judge, face: FaceModel, takes: NDArray[np.floating]) -> dict[str, Any]:
    """Error of the first take over the landmarks below the nose, and correlations of the lips."""
    frames = takes.shape[2]
    shapes = face.instance(takes[0].reshape(-1, takes.shape[3]))
    known = judge.captured(judge.measured)
    errors = vertex_error(shapes, known, judge.mouth).reshape(-1, frames).mean(axis=1)
    low, high = bootstrap_interval(mean_rows(errors), np.random.default_rng(0))
    return {
        "vertex_error_mm": float(errors.mean()),
        "interval": f"{low:.3f} to {high:.3f}",
        "aperture_r": correlation(lip_aperture(shapes, face), lip_aperture(known, face)),
        "width_r": correlation(lip_width(shapes, face), lip_width(known, face)),
    }


def spread(judge: Judge, face: FaceModel, takes: NDArray[np.floating]) -> dict[str, Any]:
    """Diversity of takes by region in mm, and as a share of how far the captured region is from its mean."""
    if len(takes) < 2:
        return {}
    shapes = np.stack([face.instance(one.reshape(-1, one.shape[-1])) for one in takes])
    known, found = judge.captured(judge.measured), {}
    for region in ("lips", "upper") if face is judge.face else ("lips", "cheeks", "jaw"):
        rows = landmark_masks(face)[region]
        rows = rows[face.moving[rows]]
        far = np.linalg.norm(known[:, rows] - face.mean[rows], axis=2).mean()
        found[f"diversity_{region}_mm"] = diversity(shapes, rows)
        found[f"diversity_{region}_share"] = found[f"diversity_{region}_mm"] / float(far)
    return found


def lively(judge: Judge, takes: NDArray[np.floating]) -> dict[str, Any]:
    """FDD of the upper face (equation 6), 0 for motion as lively as the captured; the mean over clips."""
    face, frames = judge.face, takes.shape[2]
    known = judge.captured(judge.measured).reshape(-1, frames, len(face.mean), 3)
    upper = landmark_masks(face)["upper"]
    return {
        f"fdd_{motion}_mm": float(
            np.mean(
                [
                    dynamics_deviation(face.instance(one), clip, face.mean, upper, motion)
                    for one, clip in zip(takes[0], known, strict=True)
                ]
            )
        )
        for motion in ("offset", "step")
    }


def measure_rig(judge: Judge, model: FaceDiffuser) -> dict[str, Any]:
    """Errors of ARKit's controls in hundredths of their range: all of them, and those of lips and jaw."""
    takes = takes_of(judge, model, range(TAKES if model.config.diffusion else 1))
    names, scores = judge.scores
    known = scores[judge.corpus.rows(judge.measured)].reshape(takes.shape[1:])
    apart = 100 * np.abs(takes[0] - known)
    regions = {"lips": starting(names, LIPS), "upper": starting(names, UPPER)}
    jaw = names.index("jawOpen")
    found = {
        "mce": float(apart.mean()),
        "lce": float(apart[..., regions["lips"]].mean()),
        "jaw_r": correlation(takes[0][..., jaw].ravel(), known[..., jaw].ravel()),
        "c_fdd": 100 * float((steps_of(known) - steps_of(takes[0]))[:, regions["upper"]].mean()),
    }
    pairs = np.triu_indices(len(takes), k=1)
    for region, columns in regions.items() if len(takes) > 1 else ():
        part = takes[..., columns]
        found[f"diversity_{region}"] = 100 * float(np.abs(part[pairs[0]] - part[pairs[1]]).mean())
        far = 100 * np.abs(known[..., columns] - known[..., columns].mean(axis=(0, 1))).mean()
        found[f"diversity_{region}_share"] = found[f"diversity_{region}"] / float(far)
    return found


def steps_of(curves: NDArray[np.floating]) -> NDArray[np.floating]:
    """Deviation of the change from frame to frame, (clips, frames, controls) -> (clips, controls)."""
    return np.asarray(np.abs(np.diff(curves, axis=1)).std(axis=1))


def starting(names: list[str], heads: tuple[str, ...]) -> list[int]:
    """Columns of the controls whose names begin so."""
    return [column for column, name in enumerate(names) if name.startswith(heads)]


MEASURES: dict[str, Callable[[Judge, FaceDiffuser], dict[str, Any]]] = {
    "mouth": measure_mouth,
    "face": measure_face,
    "rig": measure_rig,
}
