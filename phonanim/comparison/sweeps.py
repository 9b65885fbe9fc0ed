"""Vary one setting at a time: windows, features, the amount of training data."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.comparison.fit import CLIPS, Job, load_trained, reference_face
from phonanim.comparison.folds import all_frames, speech_frames
from phonanim.comparison.plan import Plan, Sweep
from phonanim.comparison.scores import clip_scores, measure_value
from phonanim.corpus.corpus import Corpus
from phonanim.training.recipes import predict_clip

MODEL = "model"  # the series of recipes of the plan
SPEECH = "speech_"  # before a measure: in speech alone
HELD_OUT = 0.1  # of the training clips: sweeps are for choosing settings, so they must not use test clips


def sweep_jobs(plan: Plan, corpus: Corpus, work: Path) -> list[Job]:
    """The trainings for the sweeps of a plan."""
    train, _ = split_clips(plan, corpus)
    return [
        Job(
            sweep.recipe or plan.models[values[MODEL]],
            plan.corpus,
            tuple(train[: max(1, round(len(train) * float(values.get(CLIPS, 1.0))))].tolist()),
            tuple(train.tolist()),
            _folder(work, name, values),
            {key: setting for key, setting in values.items() if key not in (CLIPS, MODEL)},
        )
        for name, sweep in plan.sweeps.items()
        for values in sweep_points(sweep)
    ]


def sweep_points(sweep: Sweep) -> list[dict[str, Any]]:
    """Settings of every point of a sweep."""
    return [
        {sweep.x: x, **({sweep.series: series} if sweep.series else {})}
        for series, x in product(sweep.of, sweep.values)
    ]


def run_sweeps(plan: Plan, corpus: Corpus, work: Path) -> dict[str, Any]:
    """Scores of every point on held-out training clips."""
    train, held_out = split_clips(plan, corpus)
    face = reference_face(plan.corpus, tuple(train.tolist()))
    found: dict[str, Any] = {}
    for name, sweep in plan.sweeps.items():
        rows = []
        for values in sweep_points(sweep):
            trained = load_trained(_folder(work, name, values))
            shapes = {
                clip: trained.model.face.instance(predict_clip(trained.model.regressor, corpus, clip))
                for clip in held_out.tolist()
            }
            measured = {}
            for prefix, where in (("", all_frames), (SPEECH, speech_frames)):
                scores = [
                    clip_scores(
                        predicted,
                        corpus.landmarks[corpus.rows([clip])],
                        face,
                        corpus.tracks[clip],
                        corpus.fps,
                        where(corpus, clip),
                    )
                    for clip, predicted in shapes.items()
                ]
                for m in scores[0]:
                    measured[prefix + m] = measure_value(m, np.array([row[m] for row in scores]))
            rows.append({**values, **measured, "training_s": trained.seconds})
        found[name] = {
            **{"x": sweep.x, "series": sweep.series, "label": sweep.label or name, "rows": rows},
            **{"clips": len(held_out), "seconds": float(corpus.frames[held_out].sum() / corpus.fps)},
        }
    return found


def split_clips(plan: Plan, corpus: Corpus) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Training clips in random order, and the held-out ones."""
    shuffled = np.random.default_rng(plan.seed).permutation(corpus.clips_of("train"))
    count = round(HELD_OUT * len(shuffled))
    return shuffled[count:], np.sort(shuffled[:count])


def _folder(work: Path, name: str, values: dict[str, Any]) -> Path:
    return work / "sweeps" / name / "_".join(f"{key}-{setting}" for key, setting in values.items())
