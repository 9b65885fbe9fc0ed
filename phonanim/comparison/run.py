"""The steps of a comparison: plan -> folds -> models -> predictions -> scores -> one JSON document."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim import regressors
from phonanim.comparison.conditions import ClipInput, clip_inputs, condition_scores, describe_conditions
from phonanim.comparison.cost import frames_per_second, line_cost, look_ahead, training_cost
from phonanim.comparison.ema import ema_scores
from phonanim.comparison.fit import (
    Job,
    Trained,
    describe_model,
    fit_all,
    folder_name,
    load_cached_corpus,
    load_trained,
    reference_face,
    seed_folders,
)
from phonanim.comparison.folds import Fold, make_folds
from phonanim.comparison.mouths import WHERE, mouth_jobs, mouth_scores, pixel_bound
from phonanim.comparison.plan import Plan
from phonanim.comparison.published import add_published
from phonanim.comparison.scores import Scores, scores_by_frames
from phonanim.comparison.sweeps import run_sweeps, sweep_jobs
from phonanim.comparison.tools import read_tools
from phonanim.core.files import make_folder_within
from phonanim.corpus.corpus import Corpus
from phonanim.face import contacts
from phonanim.face.model import FaceModel
from phonanim.training.recipes import predict_clip

VARIANTS = ("raw", "contacts")
Document = dict[str, Any]
Progress = Callable[[str, float], None]


def compare(plan: Plan, work: Path, workers: int, progress: Progress = lambda what, done: None) -> Document:
    """Train or load every model of a plan and score it in every fold; -> the document of all sums.

    `work` keeps the trained models. Sums are per clip, so that any interval or test can be computed.
    """
    corpus = load_cached_corpus(plan.corpus)
    found = list(make_folds(plan, corpus))
    document = _opening(plan, corpus, found)
    jobs = [job for fold in found for job in _jobs(plan, fold, work)]
    jobs += [*mouth_jobs(plan, corpus, work), *sweep_jobs(plan, corpus, work)]
    inputs = clip_inputs(plan, corpus, work, lambda done: progress("aligning", done))
    fit_all(jobs, workers, lambda done: progress("training", done))
    begin = time.process_time()
    document["conditions"] = describe_conditions(plan, inputs, corpus)
    for number, name in enumerate(plan.models):
        document["models"][name] = _score_model(plan, name, found, inputs, work, corpus)
        progress("scoring", (number + 1) / len(plan.models))
    for name, scores in mouth_scores(plan, work).items():
        document["models"][name]["scores"]["raw"][WHERE] = scores
    if plan.mouths:
        document["pixel_bound"] = pixel_bound(plan)
    if plan.tools is not None:
        document["tools"] = read_tools(plan.tools)
    document["sweeps"] = run_sweeps(plan, corpus, work)
    document["effort"] = training_cost(jobs) | {"scoring_s": round(time.process_time() - begin, 1)}
    return add_published(document, plan.published) if plan.published else document


def _opening(plan: Plan, corpus: Corpus, found: list[Fold]) -> Document:
    """The document without scores. Raises ModelError where the published file has other clips or the same
    names, before anything is trained.
    """
    folds = {f.name: {"train": len(f.train), "clips": [corpus.clips[c] for c in f.test]} for f in found}
    document: Document = {
        "reference": plan.reference,
        "seed": plan.seed,
        "corpus": {
            "clips": len(corpus.clips),
            "fps": corpus.fps,
            "frames": int(corpus.frames.sum()),
            **corpus.provenance,
        },
        "folds": folds,
        "models": {},
    }
    if plan.published:
        add_published({**document, "models": dict.fromkeys(plan.models)}, plan.published)
    return document


def model_folders(plan: Plan, name: str, fold: Fold, work: Path) -> list[tuple[int | None, Path]]:
    """The folder of the model of a fold for each seed, None where it is the recipe's own.

    Nothing for a model that is trained for the test clips only.
    """
    where = plan.models[name]
    if fold.name != "test" and (name in plan.test_only or where.is_dir()):
        return []
    if where.is_dir():
        return [(None, where)]
    return seed_folders(plan, name, work / folder_name(name) / fold.name)


def _jobs(plan: Plan, fold: Fold, work: Path) -> Iterable[Job]:
    for name, where in plan.models.items():
        for seed, folder in model_folders(plan, name, fold, work):
            if where.is_file():
                make_folder_within(folder, work)
                train = tuple(fold.train.tolist())
                yield Job(where, plan.corpus, train, fold.face_clips, folder, seed=seed)


def _score_model(
    plan: Plan,
    name: str,
    found: list[Fold],
    inputs: dict[str, tuple[ClipInput, ...]],
    work: Path,
    corpus: Corpus,
) -> Document:
    row: Document = {"scores": {}}
    for fold in found:
        folders = [folder for _, folder in model_folders(plan, name, fold, work)]
        if not folders:
            continue
        face = reference_face(plan.corpus, fold.face_clips)
        found_rows: dict[str, list[dict[str, dict[str, list[Any]]]]] = {variant: [] for variant in VARIANTS}
        for folder in reversed(folders):  # the first is the one that is described below
            trained = load_trained(folder)
            predicted = {
                int(clip): predict_clip(trained.model.regressor, corpus, int(clip)) for clip in fold.test
            }
            for variant in VARIANTS:
                scores = _score_fold(trained.model, predicted, variant, fold, corpus, face)
                found_rows[variant].insert(0, scores)
        for variant, by_seed in found_rows.items():
            scored = by_seed[0] if len(by_seed) == 1 else with_seeds(by_seed)
            row["scores"].setdefault(variant, {}).update(scored)
        folder = folders[0]
        if fold.name == "test":
            row |= describe_model(trained.model) | {"training_s": trained.seconds}
            row |= _cost(trained.model, folder, corpus, fold) | _pictures(trained, predicted, corpus)
            for variant, scores in condition_scores(trained.model, inputs, corpus, face).items():
                row["scores"][variant].update(scores)
            if plan.ema is not None and "ema" in plan.folds:
                row["ema"] = {v: ema_scores(trained.model, plan.ema, v == "contacts") for v in VARIANTS}
    return row


def with_seeds(by_seed: list[dict[str, dict[str, list[Any]]]]) -> dict[str, dict[str, list[Any]]]:
    """Sums of every clip by seed: clips of (seeds, sums) instead of clips of sums."""
    return {
        key: {
            measure: [list(clip) for clip in zip(*(scores[key][measure] for scores in by_seed), strict=True)]
            for measure in measures
        }
        for key, measures in by_seed[0].items()
    }


def _score_fold(
    model: regressors.Model,
    predicted: dict[int, NDArray[np.float32]],
    variant: str,
    fold: Fold,
    corpus: Corpus,
    face: FaceModel,
) -> dict[str, dict[str, list[Any]]]:
    """Sums by "fold/where", measure and clip."""
    shapes = (
        (
            clip,
            model.face.instance(enforce_contacts(modes, model, corpus, clip) if variant != "raw" else modes),
        )
        for clip, modes in predicted.items()
    )
    return scores_by_frames(fold.name, shapes, fold.where, corpus, face)


def enforce_contacts(
    modes: NDArray[np.float32], model: regressors.Model, corpus: Corpus, clip: int
) -> NDArray[np.float32]:
    """Predicted modes of a clip with the closures that `animate` guarantees."""
    return contacts.enforce_lip_contacts(modes, corpus.tracks[clip], model.face, corpus.times(clip))


def _cost(model: regressors.Model, folder: Path, corpus: Corpus, fold: Fold) -> Document:
    clips = fold.test.tolist()
    speed = frames_per_second(model, corpus, clips)
    ahead = look_ahead(model.regressor)
    return {"frames_per_s": speed, "look_ahead": ahead, **line_cost(folder, corpus, clips[0])}


def _pictures(trained: Trained, predicted: dict[int, NDArray[np.float32]], corpus: Corpus) -> Document:
    """Extra data for the figures: the first mode of the first clip, the error of each landmark."""
    face, first = trained.model.face, next(iter(predicted))
    apart = np.concatenate(
        [face.instance(modes) - corpus.landmarks[corpus.rows([clip])] for clip, modes in predicted.items()]
    )
    return {
        "first_mode": predicted[first][:, 0].round(3).tolist(),
        "landmark_error": np.linalg.norm(apart, axis=2).mean(axis=0).round(4).tolist(),
    }


def model_rows(document: Document, name: str, variant: str, where: str) -> Scores | None:
    """Sums of one model, (clips, sums) by measure; if `where` ends with *, folds are concatenated.

    The sums of several seeds are averaged, so that a statistic of them is that of all their predictions, and
    a clip weighs as much as in a model with one seed.
    """
    found = seeded_rows(document, name, variant, where)
    return found and {measure: rows.mean(axis=1) for measure, rows in found.items()}


def seeded_rows(document: Document, name: str, variant: str, where: str) -> Scores | None:
    """The same for each seed, (clips, seeds, sums) by measure."""
    scores = document["models"][name]["scores"].get(variant, {})
    fold, _, frames = where.partition("/")
    names = [key for key in scores if key.partition("/")[2] == frames and _matches(key, fold)]
    if not names:
        return None
    return {
        measure: np.concatenate([_by_seed(np.array(scores[key][measure])) for key in names])
        for measure in scores[names[0]]
    }


def _by_seed(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    return rows if rows.ndim == 3 else rows[:, None]


def _matches(key: str, fold: str) -> bool:
    name = key.partition("/")[0]
    return name.startswith(fold[:-1]) if fold.endswith("*") else name == fold
