"""Train on a corpus of other motion than landmarks: controls, sensors or vertices (phonanim/targets)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.version import __version__
from phonanim.corpus.examples import motion_examples, style_name
from phonanim.corpus.motion import MotionCorpus
from phonanim.errors import CorpusError, ModelError
from phonanim.regressors import Examples, Model, make_config, regressor_class
from phonanim.regressors._contract import check_fitted
from phonanim.targets import Target, TargetSettings, target_class
from phonanim.targets.sensors import Sensors
from phonanim.training.articulation import learn_articulation, with_zeros
from phonanim.training.recipe import Recipe

Progress = Callable[[float], None]
PHONE_TASKS = ("ctc", "classifier")
"""Settings of audio-driven models that weight tasks on phones."""


def fit_motion(
    recipe: Recipe, corpus: MotionCorpus, seed: int, config: Path, progress: Progress, journal: Path | None
) -> Model:
    """Train a recipe on the clips of the splits train and validation.

    Without a split "validation", a share of the training clips is drawn for it. Raises ModelError and
    CorpusError, which name what the corpus or the recipe lacks.
    """
    if recipe.teacher:
        raise ModelError(
            f"{config}: [teacher] predicts landmarks; leave it out for a corpus of {corpus.kind}"
        )
    rng = np.random.default_rng(seed)
    train, held = split_clips(corpus, recipe.validation, rng)
    settings = recipe.target or TargetSettings()
    target: Target = target_class(corpus.kind).fit(settings, corpus.source, corpus.examples(train))
    if isinstance(target, Sensors):
        target = with_zeros(target, corpus, train)
    styles = style_names(corpus, train, settings.styles)
    made = make_config(recipe.kind, with_styles(recipe.kind, recipe.settings or {}, len(styles)), str(config))
    named = styles if getattr(made, "styles", 1) > 1 else ()
    learned, held_out = (
        motion_examples(corpus, target, clips, named, settings.styles) for clips in (train, held)
    )
    check_inputs(recipe.kind, made, corpus, learned, config)
    fit: Any = regressor_class(recipe.kind).fit
    if journal and getattr(regressor_class(recipe.kind), "resumable", False):
        fit = partial(fit, journal=journal)
    regressor = fit(made, learned, held_out, rng, progress)
    if regressor.input_modality == "phones":
        check_fitted(regressor, recipe.kind, learned.tracks[0], learned.times[0], target.size)
    card = {
        "fps": corpus.fps,
        "styles": list(named),
        "provenance": {
            "tool": f"phonanim {__version__}",
            "corpus": corpus.provenance,
            "licence": recipe.licence,
            "seed": seed,
            "recipe": config.name,
            "clips": len(train),
            "seconds": round(sum(corpus.clips[n].frames for n in train) / corpus.fps, 1),
            "speakers": len({corpus.clips[n].subject for n in train}),
        },
    }
    articulation = learn_articulation(regressor, learned) if isinstance(target, Sensors) else None
    return Model(regressor, target, card, articulation)


def split_clips(
    corpus: MotionCorpus, share: float, rng: np.random.Generator
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Numbers of the clips to train on and to validate with, sorted. Raises CorpusError."""
    train, held = corpus.clips_of("train"), corpus.clips_of("validation")
    if not len(train):
        raise CorpusError(f"the corpus of {corpus.source.data} has no clips of the split train")
    if len(held):
        return train, held
    shuffled = rng.permutation(train)
    count = min(round(share * len(train)), len(train) - 1)
    return np.sort(shuffled[count:]), np.sort(shuffled[:count])


def style_names(corpus: MotionCorpus, clips: Sequence[int] | NDArray[np.int64], by: str) -> tuple[str, ...]:
    """The styles of the training clips, sorted; one for all with "none"."""
    return tuple(sorted({style_name(corpus.clips[int(clip)], by) for clip in clips}))


def with_styles(kind: str, values: Mapping[str, Any], count: int) -> dict[str, Any]:
    """The settings of a kind, which has as many styles as the corpus unless they say otherwise.

    So have the members of an ensemble, each of a kind of its own.
    """
    known = getattr(regressor_class(kind).config_class, "__dataclass_fields__", {})
    filled = {"styles": count, **values} if "styles" in known else dict(values)
    members = values.get("members") if "members" in known else None
    if isinstance(members, list) and all(isinstance(one, dict) and "kind" in one for one in members):
        filled["members"] = [with_styles(one["kind"], one, count) for one in members]
    return filled


def check_inputs(kind: str, values: Any, corpus: MotionCorpus, learned: Examples, config: Path) -> None:
    """Raise ModelError where a kind reads phones or sound that the corpus lacks."""
    modality = regressor_class(kind).input_modality
    tasks = [name for name in PHONE_TASKS if getattr(values, name, 0)]
    if tasks and not all(clip.aligned for clip in corpus.clips if clip.split == "train"):
        raise ModelError(f"{config}: {' and '.join(tasks)} needs phones, and clips have none; set it to 0")
    if modality != "audio" and not all(clip.aligned for clip in corpus.clips if clip.split == "train"):
        raise ModelError(
            f"{config}: {kind} reads phones, and clips of the corpus have none; align them (phonanim align, "
            "textgrid/ of the imported folder) or use an audio-driven kind, such as phisanet"
        )
    if modality != "phones" and not learned.sounds:
        raise ModelError(
            f"{config}: {kind} is audio-driven, and the clips have no sound; use a phone-driven kind"
        )
