"""The comparison on controls, sensors or vertices: plan -> folds -> models -> sums of every clip."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.comparison.cost import training_cost
from phonanim.comparison.fit import (
    Job,
    describe_model,
    fit_all,
    folder_name,
    load_cached_motion,
    load_trained,
    seed_folders,
)
from phonanim.comparison.motion_folds import MotionFold, motion_folds, training_part
from phonanim.comparison.motion_scores import clip_sums, curve_names
from phonanim.comparison.plan import LEFT_OUT, Plan
from phonanim.comparison.run import Document, Progress, with_seeds
from phonanim.core.files import make_folder_within
from phonanim.corpus.motion import MotionCorpus
from phonanim.errors import EvaluationError, ModelError
from phonanim.evaluation.corpora import STILL, check_same_motion, mean_frame, motion_of, predict_frames
from phonanim.evaluation.heat import Heat
from phonanim.face.masks import parse_masks

Rows = NDArray[np.int64]
Sums = dict[str, dict[str, list[Any]]]  # by "fold/frames", measure and piece
OF_LANDMARKS = ("ema", "tools", "legibility", "published", "mouths", "conditions", "sweeps")
"""Keys of a plan that need a corpus of landmarks."""


def compare_motion(
    plan: Plan, work: Path, workers: int, progress: Progress = lambda what, done: None
) -> Document:
    """Train or load every model of a plan and score it in every fold; -> the document of all sums.

    Raises ModelError for what a plan of such a corpus cannot have, EvaluationError for a model of another.
    """
    _check_plan(plan)
    corpus = load_cached_motion(plan.corpus)
    masks = parse_masks(tuple(f"{region}={path}" for region, path in plan.masks.items()))
    folds = motion_folds(plan, corpus)
    jobs = [job for fold in folds for job in _jobs(plan, fold, work)]
    fit_all(jobs, workers, lambda done: progress("training", done))
    begin, curves, heat = time.process_time(), curve_names(corpus), Heat()
    document: Document = {
        "reference": plan.reference,
        "seed": plan.seed,
        "kind": corpus.kind,
        "curves": list(curves),
        "corpus": {"data": corpus.source.data, "unit": corpus.source.unit, "fps": corpus.fps}
        | corpus.provenance,
        "folds": {fold.name: _describe(fold, corpus) for fold in folds},
        "models": {},
    }
    for number, name in enumerate((*plan.models, STILL), start=1):
        document["models"][name] = _score_model(plan, name, folds, work, corpus, curves, masks, heat)
        progress("scoring", number / (len(plan.models) + 1))
    document["heat"] = heat.facts()
    document["effort"] = training_cost(jobs) | {"scoring_s": round(time.process_time() - begin, 1)}
    return document


def _check_plan(plan: Plan) -> None:
    """Raise ModelError for what a plan of such a corpus cannot have."""
    for key in OF_LANDMARKS:
        if getattr(plan, key):
            raise ModelError(f"{plan.corpus}: {key} needs a corpus of landmarks; leave it out of the plan")
    for name, where in plan.models.items():
        if where.is_dir() and "test" not in plan.folds:
            raise ModelError(
                f"{where}: models.{name} is trained already, and folds = {list(plan.folds)} train anew; "
                'give its recipe, or use "test"'
            )


def model_folders(plan: Plan, name: str, fold: MotionFold, work: Path) -> list[tuple[int | None, Path]]:
    """The folder of the model of a fold for each seed; nothing for one that is not trained for it."""
    where = plan.models[name]
    if where.is_dir():
        return [(None, where)] if fold.model == "test" else []
    if name in plan.test_only and not _is_main(fold):
        return []
    return seed_folders(plan, name, work / folder_name(name) / fold.model)


def _is_main(fold: MotionFold) -> bool:
    """Whether a fold is one of the test clips, not of withheld words or phones."""
    return fold.model == "test" or fold.name.startswith(LEFT_OUT)


def _jobs(plan: Plan, fold: MotionFold, work: Path) -> Iterator[Job]:
    for name, where in plan.models.items():
        for seed, folder in model_folders(plan, name, fold, work):
            if where.is_file() and fold.name == fold.model:
                make_folder_within(folder, work)
                yield Job(where, plan.corpus, fold.train, (), folder, seed=seed)


def _describe(fold: MotionFold, corpus: MotionCorpus) -> dict[str, Any]:
    """Clips, seconds and speakers of a fold."""
    tested = [corpus.clips[clip] for clip in fold.test]
    spoken = [where(corpus, clip) for clip in fold.test for where in (fold.where.get("speech"),) if where]
    known = [chosen for chosen in spoken if chosen is not None]
    return {
        "train": len(fold.train),
        "train_s": round(sum(corpus.clips[clip].frames for clip in fold.train) / corpus.fps, 1),
        "train_speakers": sorted({corpus.clips[clip].subject for clip in fold.train}),
        "clips": [one.name for one in tested],
        "seconds": round(sum(one.frames for one in tested) / corpus.fps, 1),
        "spoken_s": round(sum(int(chosen.sum()) for chosen in known) / corpus.fps, 1) if known else None,
        "aligned": all(one.aligned for one in tested),
        "speakers": sorted({one.subject for one in tested}),
    }


def _score_model(
    plan: Plan,
    name: str,
    folds: list[MotionFold],
    work: Path,
    corpus: MotionCorpus,
    curves: tuple[str, ...],
    masks: dict[str, Rows],
    heat: Heat,
) -> Document:
    """The sums of a model, or of a face that stays at the mean of training."""
    row: Document = {"driven_by": "", "scores": {"raw": {}}}
    for fold in folds:
        if name == STILL:
            predicts = [_still(fold, corpus)]
        else:
            folders = [folder for _, folder in model_folders(plan, name, fold, work)]
            predicts = [_predictor(name, folder, corpus, row) for folder in folders]
        if not predicts:
            continue
        by_seed = [
            _sums(one, fold, corpus, curves, masks, heat if _is_main(fold) else None, name)
            for one in predicts
        ]
        row["scores"]["raw"] |= by_seed[0] if len(by_seed) == 1 else with_seeds(by_seed)
    return row


def _predictor(
    name: str, folder: Path, corpus: MotionCorpus, row: Document
) -> Callable[[int], NDArray[np.floating]]:
    """What predicts the frames of a clip; the first model of a name is described in its row."""
    trained = load_trained(folder)
    check_same_motion(name, trained.model, corpus)
    if "kind" not in row:
        row |= describe_model(trained.model) | {"training_s": trained.seconds}

    def predict(clip: int) -> NDArray[np.floating]:
        begin = time.process_time()
        frames = predict_frames(trained.model, corpus, clip)
        row["predicting_s"] = row.get("predicting_s", 0.0) + time.process_time() - begin
        row["predicted"] = row.get("predicted", 0) + len(frames)
        return frames

    return predict


def _still(fold: MotionFold, corpus: MotionCorpus) -> Callable[[int], NDArray[np.floating]]:
    """A mouth that does not move: the subject at rest, or else the mean of the fold's training."""
    mean = mean_frame(training_part(corpus, fold.train)) if corpus.kind != "vertices" else np.zeros(())

    def predict(clip: int) -> NDArray[np.floating]:
        rest = corpus.rest(clip)
        still = mean if rest is None else rest
        return np.broadcast_to(still, (corpus.clips[clip].frames, *still.shape))

    return predict


def _sums(
    predict: Callable[[int], NDArray[np.floating]],
    fold: MotionFold,
    corpus: MotionCorpus,
    curves: tuple[str, ...],
    masks: dict[str, Rows],
    heat: Heat | None,
    name: str,
) -> Sums:
    """Sums by "fold/frames", measure and piece. Frames whose speech is unknown are left out."""
    rows: dict[str, list[dict[str, list[float]]]] = defaultdict(list)
    for clip in fold.test:
        captured, predicted = np.asarray(corpus.finite_frames(clip)), np.asarray(predict(clip))
        if predicted.shape != captured.shape:
            raise EvaluationError(
                f"{name}: predicts {predicted.shape[1:]}, and the clip has {captured.shape[1:]}"
            )
        for frames, where in fold.where.items():
            chosen = where(corpus, clip)
            if chosen is not None and chosen.any():
                pieces = clip_sums(predicted, captured, corpus, clip, chosen, curves, masks)
                rows[f"{fold.name}/{frames}"] += pieces
        if heat is not None and name != STILL:
            heat.add({name: motion_of(predicted, corpus)}, motion_of(captured, corpus))
    return {key: _by_measure(pieces) for key, pieces in rows.items()}


def _by_measure(pieces: Iterable[dict[str, list[float]]]) -> dict[str, list[Any]]:
    every = list(pieces)
    return {measure: [piece[measure] for piece in every] for measure in every[0]}
