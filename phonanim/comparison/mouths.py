"""Pixels: the models of a plan as rendered mouths, in the joint modes of shape and appearance."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from phonanim.comparison.fit import Job, folder_name, load_cached_corpus
from phonanim.comparison.plan import Plan
from phonanim.corpus.corpus import Corpus
from phonanim.corpus.pictures import Captured, load_captured, pixel_mse
from phonanim.training.mouth import load_mouth

WHERE = "pixels/all"  # the key of mouths among the other scores


def mouth_jobs(plan: Plan, corpus: Corpus, work: Path) -> list[Job]:
    """The trainings for the mouths of a plan: the same recipes on the same clips, with joint targets."""
    clips = tuple(corpus.clips_of("train").tolist())
    return [
        Job(plan.models[name], plan.corpus, clips, clips, mouth_folder(work, name), mouth=True)
        for name in plan.mouths
    ]


def mouth_folder(work: Path, name: str) -> Path:
    """The folder of the mouth of a model."""
    return work / folder_name(name) / "mouth"


def mouth_scores(plan: Plan, work: Path) -> dict[str, dict[str, list[list[float]]]]:
    """Sums of squared errors of every test clip, by model and measure; empty for a plan without mouths.

    Parameters are those of the joint modes; pixels are grey levels in the reference shape, in mean light
    (Taylor 2017, section 8).
    """
    if not plan.mouths:
        return {}
    corpus, captured = load_cached_corpus(plan.corpus), load_captured(plan.corpus)
    return {name: _scores(mouth_folder(work, name), corpus, captured) for name in plan.mouths}


def pixel_bound(plan: Plan) -> list[list[float]]:
    """Sums of the squared pixel error of the appearance model itself on every test clip."""
    captured = load_captured(plan.corpus)
    error = pixel_mse(captured.model, captured.joint[captured.rows], captured.grey).whole
    return [_sum(part) for part in np.split(error, _bounds(load_cached_corpus(plan.corpus)))]


def _scores(folder: Path, corpus: Corpus, captured: Captured) -> dict[str, list[list[float]]]:
    mouth, clips = load_mouth(folder), corpus.clips_of("test").tolist()
    joint = np.concatenate([mouth.predict(corpus.tracks[c], corpus.times(c)) for c in clips])
    pixels = pixel_mse(captured.model, joint, captured.grey)
    errors = {
        "joint_mse": ((joint - captured.joint[captured.rows]) ** 2).mean(axis=1),
        "pixel_mse": pixels.whole,
        "inner_pixel_mse": pixels.inner,
        "outer_pixel_mse": pixels.outer,
    }
    bounds = _bounds(corpus)
    return {name: [_sum(part) for part in np.split(error, bounds)] for name, error in errors.items()}


def _bounds(corpus: Corpus) -> Any:
    return np.cumsum(corpus.frames[corpus.clips_of("test")])[:-1]


def _sum(part: Any) -> list[float]:
    return [float(f"{part.sum():.9g}"), float(len(part))]
