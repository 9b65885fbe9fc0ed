"""Train a model folder from a configuration file."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim import regressors
from phonanim.core.catalog import DEFAULT_MODEL, find_model
from phonanim.core.version import __version__
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.corpus.examples import make_examples
from phonanim.corpus.motion import has_own_motion, load_motion_corpus
from phonanim.errors import CorpusError
from phonanim.face.fit import fit_face
from phonanim.face.model import FaceModel, lip_aperture, lip_width
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import read_sound
from phonanim.metrics import correlation, vertex_error
from phonanim.regressors import (
    CHECKPOINT,
    Examples,
    Model,
    Regressor,
    load_face,
    make_config,
    regressor_class,
)
from phonanim.regressors._contract import check_fitted
from phonanim.speech.language import to_phones
from phonanim.training.articulation import learn_articulation
from phonanim.training.motion import fit_motion
from phonanim.training.recipe import Recipe, Teacher, read_recipe

LONGEST_CLIP = 30.0  # seconds of one natural-text line that are used


def train(
    config: Path,
    output: Path | None = None,
    seed: int | None = None,
    progress: Callable[[float], None] = lambda done: None,
) -> Path:
    """Train the model that a TOML file describes; returns its folder (`models/NAME` by default).

    Paths in the file are relative to it. The same file, data and seed give the same bytes. A `resumable` kind
    saves its state and its losses in the folder during training, and continues from there after an
    interruption. Raises ModelError or CorpusError, which name the file and the invalid key.
    """
    recipe = read_recipe(config)
    seed = recipe.seed if seed is None else seed
    source = config.parent / recipe.corpus
    folder = output or Path("models") / (recipe.name or config.stem)
    if not has_own_motion(source):
        corpus = load_corpus(source)
        model = fit_recipe(recipe, corpus, corpus.clips_of("train"), seed, config, progress, journal=folder)
    else:
        model = fit_motion(recipe, load_motion_corpus(source), seed, config, progress, folder)
    regressors.save(model, folder)
    (folder / CHECKPOINT).unlink(missing_ok=True)
    return folder


def fit_recipe(
    recipe: Recipe,
    corpus: Corpus,
    clips: NDArray[np.int64],
    seed: int,
    config: Path,
    progress: Callable[[float], None] = lambda done: None,
    face: FaceModel | None = None,
    journal: Path | None = None,
) -> Model:
    """Train on some clips of a corpus (folds of a benchmark, or all training clips).

    `journal` is a folder for the state of `resumable` kinds.
    """
    rng = np.random.default_rng(seed)
    if face is None:
        shipped = load_face(find_model(DEFAULT_MODEL) / "face.safetensors")
        face = fit_face(corpus.landmarks[corpus.rows(clips)], corpus.indices, known=shipped)
    shuffled = rng.permutation(clips)
    n_held_out = round(recipe.validation * len(clips))
    with_sound = regressor_class(recipe.kind).input_modality != "phones"
    held_out = make_examples(corpus, face, np.sort(shuffled[:n_held_out]), with_sound)
    recordings = make_examples(corpus, face, np.sort(shuffled[n_held_out:]), with_sound)
    if recipe.teacher:
        recordings = add_teacher_examples(
            recordings, held_out, recipe.teacher, config, rng, lambda d: progress(d / 2)
        )
    settings = make_config(recipe.kind, recipe.settings or {}, str(config))
    base = 0.5 if recipe.teacher else 0.0
    fit: Any = regressor_class(recipe.kind).fit
    if journal and getattr(regressor_class(recipe.kind), "resumable", False):
        fit = partial(fit, journal=journal)
    regressor = fit(settings, recordings, held_out, rng, lambda done: progress(base + (1 - base) * done))
    if not with_sound:
        check_fitted(regressor, recipe.kind, recordings.tracks[0], recordings.times[0], len(face.std))
    card = {
        "fps": corpus.fps,
        "provenance": {
            "tool": f"phonanim {__version__}",
            "corpus": corpus.provenance,
            "licence": recipe.licence,
            "seed": seed,
            "recipe": config.name,
            "clips": len(clips),
            "scores": validation_scores(regressor, corpus, face, np.sort(shuffled[:n_held_out])),
        },
    }
    return Model(regressor, face, card, learn_articulation(regressor, recordings))


def add_teacher_examples(
    recordings: Examples,
    held_out: Examples,
    teacher: Teacher,
    config: Path,
    rng: np.random.Generator,
    progress: Callable[[float], None],
) -> Examples:
    """The recordings, plus natural text as the teacher predicts it (knowledge distillation).

    The teacher is fitted to the recordings only. Its instants on natural text have a random phase of the
    frame grid, so that the network is trained at every position in a phone.
    """
    settings = make_config("ensemble", {"members": list(teacher.members)}, f"{config}: [teacher]")
    ensemble = regressor_class("ensemble").fit(settings, recordings, held_out, rng, progress)
    tracks, times, targets = [], [], []
    for path in _natural_lines(teacher, config, rng):
        track = to_phones(read_alignment(path), unknown="nearest")[0]
        at = np.arange(rng.uniform(0, 0.04), min(track.duration, LONGEST_CLIP), 0.04)
        tracks.append(track)
        times.append(at)
        targets.append(ensemble.predict(track, at))
    natural = Examples(tuple(tracks), tuple(times), tuple(targets), (teacher.weight,) * len(tracks))
    blended = tuple(
        (1 - teacher.blend) * target + teacher.blend * ensemble.predict(track, at)
        for track, at, target in zip(recordings.tracks, recordings.times, recordings.targets, strict=True)
    )
    spoken = Examples(recordings.tracks, recordings.times, blended, recordings.weights)
    return spoken + natural


def _natural_lines(teacher: Teacher, config: Path, rng: np.random.Generator) -> list[Path]:
    found: list[Path] = []
    for folder in teacher.natural:
        lines = sorted((config.parent / folder).rglob("*.TextGrid"))
        if not lines:
            raise CorpusError(f"{config}: [teacher] natural: no TextGrid in {config.parent / folder}")
        found += lines
    return [found[i] for i in sorted(rng.permutation(len(found))[: teacher.clips])]


def predict_clip(regressor: Regressor, corpus: Corpus, clip: int) -> NDArray[np.float32]:
    """Modes of one clip at its mid-exposure instants, -> (frames, modes). Raises AudioError."""
    sound = None if regressor.input_modality == "phones" else read_sound(corpus.audio[clip])
    return regressor.predict(corpus.tracks[clip], corpus.times(clip), sound)


def validation_scores(
    regressor: Regressor, corpus: Corpus, face: FaceModel, clips: NDArray[np.int64]
) -> dict[str, float]:
    """Vertex error (mm) and correlations of aperture and width on the clips of the validation split."""
    if len(clips) == 0:
        return {}
    predicted = np.concatenate([predict_clip(regressor, corpus, int(clip)) for clip in clips])
    shapes, captured = face.instance(predicted), corpus.landmarks[corpus.rows(clips)]
    return {
        "validation_vertex_error_mm": round(float(vertex_error(shapes, captured, face).mean()), 3),
        "validation_aperture_r": round(
            correlation(lip_aperture(shapes, face), lip_aperture(captured, face)), 3
        ),
        "validation_width_r": round(correlation(lip_width(shapes, face), lip_width(captured, face)), 3),
    }
