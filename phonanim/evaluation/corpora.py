"""Score models of controls, sensors or vertices on the clips of their corpus (phonanim/corpus/motion.py)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.animation.own_motion import rig_of_names
from phonanim.core.files import atomic_path, make_folder_within
from phonanim.corpus.examples import read_clip_sound, style_name
from phonanim.corpus.motion import MotionCorpus
from phonanim.errors import EvaluationError
from phonanim.evaluation.evaluate import evaluate
from phonanim.evaluation.heat import Heat
from phonanim.evaluation.measures import control_measures, control_regions
from phonanim.evaluation.predictions import Motion, Vertices
from phonanim.evaluation.scoring import Scores
from phonanim.metrics import correlation, sd_ratio
from phonanim.regressors import Model, in_style
from phonanim.targets.sensors import mouth_channels
from phonanim.training.motion import fit_motion
from phonanim.training.recipe import read_recipe

CAPTURED, STILL = "captured", "mean of training"
"""The folder of captured motion, and the row of a face that does not move."""
LIVELY = 10  # controls that move most in a clip, whose correlations are told


def score_models(
    models: Mapping[str, Model],
    corpus: MotionCorpus,
    split: str = "test",
    masks: Mapping[str, NDArray[np.int64]] | None = None,
    output: Path | None = None,
    progress: Callable[[float], None] = lambda done: None,
    heat: Heat | None = None,
) -> dict[str, dict[str, Scores]]:
    """The scores of models on every clip of a split, by model and clip, STILL among them.

    With `output`, predicted and captured motion is written there, a folder for each. `heat` gets the errors
    of the models. Raises EvaluationError
    where a model is of other motion than the corpus, or the split is empty.
    """
    clips = [int(clip) for clip in corpus.clips_of(split)]
    if not clips:
        there = ", ".join(sorted({clip.split for clip in corpus.clips}))
        raise EvaluationError(f"the corpus has no clips of the split {split!r}; choose --split of {there}")
    for name, model in models.items():
        check_same_motion(name, model, corpus)
    found = {name: dict[str, Scores]() for name in (*models, STILL)}
    mean = mean_frame(corpus) if corpus.rest(clips[0]) is None else np.zeros(())
    for done, clip in enumerate(clips, start=1):
        for name, scores in score_one(models, corpus, clip, mean, masks, output, heat).items():
            found[name][corpus.clips[clip].name] = scores
        progress(done / len(clips))
    return found


def score_left_out(
    recipes: Sequence[Path],
    corpus: MotionCorpus,
    masks: Mapping[str, NDArray[np.int64]] | None = None,
    output: Path | None = None,
    progress: Callable[[float], None] = lambda done: None,
    heat: Heat | None = None,
) -> dict[str, dict[str, Scores]]:
    """The scores of recipes that are trained anew without each clip in turn, by recipe and clip.

    Raises what training raises, and EvaluationError for a corpus of a single clip.
    """
    count = len(corpus.clips)
    if count < 2:
        raise EvaluationError("the corpus has one clip, and none is left to train on")
    found = {name: dict[str, Scores]() for name in (*(recipe.stem for recipe in recipes), STILL)}
    for clip in range(count):
        others = tuple(
            replace(one, split="test" if number == clip else "train")
            for number, one in enumerate(corpus.clips)
        )
        rest, models = replace(corpus, clips=others), dict[str, Model]()
        for path in recipes:
            recipe = read_recipe(path)
            models[path.stem] = fit_motion(recipe, rest, recipe.seed, path, lambda done: None, None)
        for name, scores in score_one(models, rest, clip, mean_frame(rest), masks, output, heat).items():
            found[name][corpus.clips[clip].name] = scores
        progress((clip + 1) / count)
    return found


def score_one(
    models: Mapping[str, Model],
    corpus: MotionCorpus,
    clip: int,
    mean: NDArray[np.float64],
    masks: Mapping[str, NDArray[np.int64]] | None,
    output: Path | None,
    heat: Heat | None = None,
) -> dict[str, Scores]:
    """The scores of models and of a still face on a clip.

    With `output`, the motion is written there; with `heat`, the errors of the models are added to it.
    """
    captured, name = motion_of(np.asarray(corpus.frames(clip)), corpus), corpus.clips[clip].name
    predicted = {one: motion_of(predict_frames(model, corpus, clip), corpus) for one, model in models.items()}
    if output:
        write_motions({**predicted, CAPTURED: captured}, name, output)
    if heat is not None:
        heat.add(predicted, captured)
    rest = corpus.rest(clip)
    still = mean if rest is None else rest
    frames = np.broadcast_to(still, (corpus.clips[clip].frames, *still.shape))
    predicted[STILL] = motion_of(np.array(frames), corpus)
    return {one: score_clip(motion, captured, corpus, clip, masks) for one, motion in predicted.items()}


def score_clip(
    motion: Motion,
    captured: Motion,
    corpus: MotionCorpus,
    clip: int,
    masks: Mapping[str, NDArray[np.int64]] | None,
) -> Scores:
    """Every measure of one clip, with its phones where it has some.

    Controls of a rig that is not shipped are scored as curves: a name that a shipped head has, too, may mean
    another thing there.
    """
    if corpus.kind == "controls" and not rig_of_names(corpus.source.names):
        assert isinstance(motion, Animation)
        assert isinstance(captured, Animation)
        regions = control_regions(corpus.source.names, masks or {})
        measures = control_measures(motion, captured, regions) | follow_controls(motion, captured)
        return Scores(measures, len(captured.values), captured.fps, "control_mse")
    one, rest = corpus.clips[clip], corpus.rest(clip) if corpus.kind == "vertices" else None
    unit = corpus.source.unit if corpus.source.unit in ("m", "cm", "mm") and rest is not None else None
    track = one.track if one.aligned else None
    return evaluate(motion, captured, alignment=track, masks=masks, template=rest, unit=unit)


def follow_controls(motion: Animation, captured: Animation) -> dict[str, float]:
    """How the LIVELY controls follow the captured ones: r and the ratio of deviations, and their means."""
    order = np.argsort(-captured.values.std(axis=0), kind="stable")[:LIVELY]
    lively = [int(row) for row in order if captured.values[:, row].std() > 0]
    found = {}
    for row in lively:
        pair = motion.values[:, row].astype(np.float64), captured.values[:, row].astype(np.float64)
        found[f"{captured.channels[row]}_r"] = correlation(*pair)
        found[f"{captured.channels[row]}_sd_ratio"] = sd_ratio(*pair)
    for name in ("r", "sd_ratio"):
        values = [value for key, value in found.items() if key.endswith(f"_{name}")]
        found[f"control_{name}"] = float(np.mean(values)) if values else np.nan
    return found


def check_same_motion(name: str, model: Model, corpus: MotionCorpus) -> None:
    """Raise EvaluationError when a model does not move what a corpus has."""
    names = getattr(model.target, "names", corpus.source.names)
    if model.target.kind != corpus.kind or (corpus.source.names and names != corpus.source.names):
        raise EvaluationError(
            f"{name}: moves {model.target.kind}, and the corpus has {corpus.kind} of {corpus.source.data}; "
            "train it on this corpus"
        )


def predict_frames(model: Model, corpus: MotionCorpus, clip: int) -> NDArray[np.floating]:
    """The motion of a clip as a model predicts it, (frames, ...), in the corpus' unit. Raises AudioError."""
    one = corpus.clips[clip]
    sound = None if model.regressor.input_modality == "phones" else read_clip_sound(one)
    regressor = in_style(model, (style_name(one, by) for by in STYLES))
    rows = regressor.predict(one.track, corpus.times(clip), sound)
    return model.target.decode(rows, corpus.rest(clip))


ARTICULATION = "articulation"  # the rig whose controls are the channels of articulation
STYLES = ("speaker and emotion", "speaker", "emotion")


def motion_of(frames: NDArray[np.floating], corpus: MotionCorpus) -> Motion:
    """Frames of a corpus as motion that can be scored."""
    if corpus.kind == "vertices":
        return Vertices(frames.astype(np.float64), corpus.fps)
    if corpus.kind == "sensors":
        channels = mouth_channels(frames, corpus.source.names)
        curves = np.stack(list(channels.values()), axis=1).astype(np.float32)
        return Animation(curves, tuple(channels), corpus.fps, rig=ARTICULATION)
    names = corpus.source.names or tuple(map(str, range(frames.shape[1])))
    return Animation(frames.astype(np.float32), names, corpus.fps, rig=corpus.source.data)


def mean_frame(corpus: MotionCorpus) -> NDArray[np.float64]:
    """The mean of the training frames."""
    total, count = np.zeros(()), 0
    for clip in corpus.clips_of("train"):
        total = total + np.asarray(corpus.frames(int(clip)), np.float64).sum(axis=0)
        count += corpus.clips[int(clip)].frames
    return np.asarray(total / max(count, 1))


def write_motions(motions: Mapping[str, Motion], clip: str, output: Path) -> None:
    """Write the motion of a clip, a folder for each name: .npz of curves, .npy of vertices."""
    for name, motion in motions.items():
        folder = make_folder_within(output / Path(name).name, output)
        if isinstance(motion, Animation):
            motion.save(folder / f"{clip}.npz")
        else:
            with atomic_path(folder / f"{clip}.npy") as path, path.open("wb") as file:
                np.save(file, motion.points.astype(np.float32))


def mean_measures(scores: Sequence[Scores]) -> dict[str, float]:
    """Each measure as a mean over clips, weighted by their frames; NaN does not count."""
    found = {}
    for name in dict.fromkeys(name for one in scores for name in one.measures):
        values = np.array([one.measures.get(name, np.nan) for one in scores])
        known, weights = np.isfinite(values), np.array([one.frames for one in scores])
        if known.any():
            found[name] = float(np.average(values[known], weights=weights[known]))
    return found
