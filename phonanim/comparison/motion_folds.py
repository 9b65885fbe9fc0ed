"""The clips of a corpus of controls, sensors or vertices: for training, for testing, and where they speak."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim import metrics
from phonanim.comparison.folds import in_words, near_phones
from phonanim.comparison.plan import LEFT_OUT, Plan
from phonanim.corpus.examples import read_clip_sound
from phonanim.corpus.motion import MotionCorpus
from phonanim.errors import ModelError
from phonanim.media.voice import FRAMES, analyze_voice
from phonanim.speech.inventory import INVENTORY

Chosen = NDArray[np.bool_]
Where = Callable[[MotionCorpus, int], Chosen | None]  # corpus, clip -> (frames,), None where it is unknown
TESTED = {"test": "test", "test_b": "unseen speakers"}
"""Splits that are tested, and the names of their folds."""


@dataclass(frozen=True)
class MotionFold:
    """`test` clips of a fold `name`, scored after training on the clips `train`; `where`: frames by name.

    `model` is the name of the fold whose training it uses.
    """

    name: str
    train: tuple[int, ...]
    test: tuple[int, ...]
    where: dict[str, Where]
    model: str


def motion_folds(plan: Plan, corpus: MotionCorpus) -> list[MotionFold]:
    """Every fold of a plan. Raises ModelError for one that the corpus does not allow."""
    folds = [*_splits(plan, corpus), *_left_out(plan, corpus), *_withheld(plan, corpus)]
    if not any(fold.name in ("test", f"{LEFT_OUT}1") for fold in folds):
        raise ModelError(
            f'{plan.corpus}: has no clips of the split test; use folds = ["{LEFT_OUT}"], which leaves out '
            "each clip in turn"
        )
    return folds


def _splits(plan: Plan, corpus: MotionCorpus) -> Iterator[MotionFold]:
    if "test" not in plan.folds:
        return
    train = tuple(corpus.clips_of("train", "validation").tolist())
    for split, name in TESTED.items():
        clips = tuple(corpus.clips_of(split).tolist())
        if clips:
            yield MotionFold(name, train, clips, {"all": all_frames, "speech": speech_frames}, "test")


def _left_out(plan: Plan, corpus: MotionCorpus) -> Iterator[MotionFold]:
    if LEFT_OUT not in plan.folds:
        return
    every = range(len(corpus.clips))
    if len(every) < 2:
        raise ModelError(f"{plan.corpus}: has one clip, and none is left to train on")
    for clip in every:
        train = tuple(other for other in every if other != clip)
        name = f"{LEFT_OUT}{clip + 1}"
        yield MotionFold(name, train, (clip,), {"all": all_frames, "speech": speech_frames}, name)


def _withheld(plan: Plan, corpus: MotionCorpus) -> Iterator[MotionFold]:
    """Folds as those of landmarks: every third clip with a word is tested, every second with a phone."""
    groups = plan.words if "words" in plan.folds else ()
    phones = plan.phones if "phones" in plan.folds else ()
    train = corpus.clips_of("train", "validation")
    if (groups or phones) and not all(corpus.clips[clip].aligned for clip in train):
        raise ModelError(
            f"{plan.corpus}: folds of words and phones need phones, and clips have none; align them "
            "(phonanim align, textgrid/ of the imported folder), or leave out words and phones"
        )
    for number, group in enumerate(groups):
        holds = np.array([any(w.label in group for w in corpus.clips[c].words) for c in train])
        where: dict[str, Where] = {"clip": speech_frames, "word": word_frames(group)}
        yield _fold(f"words{number + 1}", train, holds, 3, where, plan)
    if phones:
        codes = INVENTORY.codes(phones)
        holds = np.array([np.isin(corpus.clips[c].track.codes, codes).any() for c in train])
        yield _fold("phones", train, holds, 2, {"near": phone_frames(phones)}, plan)


def _fold(
    name: str, train: NDArray[np.int64], holds: Chosen, every: int, where: dict[str, Where], plan: Plan
) -> MotionFold:
    if not holds.any() or holds.all():
        which = "no training clip" if not holds.any() else "every training clip"
        raise ModelError(f"{plan.corpus}: {which} has what the fold {name} withholds; choose others")
    return MotionFold(name, tuple(train[~holds].tolist()), tuple(train[holds][::every].tolist()), where, name)


def training_part(corpus: MotionCorpus, clips: tuple[int, ...]) -> MotionCorpus:
    """The corpus with these clips for training (or validation, where they are of that split) alone."""
    chosen = {*clips}
    split = {"validation": "validation"}
    ones = (
        replace(one, split=split.get(one.split, "train") if number in chosen else "withheld")
        for number, one in enumerate(corpus.clips)
    )
    return replace(corpus, clips=tuple(ones))


def all_frames(corpus: MotionCorpus, clip: int) -> Chosen:
    """All frames of a clip."""
    return np.ones(corpus.clips[clip].frames, bool)


def speech_frames(corpus: MotionCorpus, clip: int) -> Chosen | None:
    """Frames of a clip that are speech: by its phones, else by the level of its sound."""
    one = corpus.clips[clip]
    if one.aligned:
        return metrics.speech_mask(one.track, corpus.times(clip))
    if one.audio is None:
        return None
    sound = read_clip_sound(one)
    spoken = analyze_voice(sound.samples, sound.rate).active()
    if not spoken.any():
        return None
    rows = np.rint(corpus.times(clip) * FRAMES).astype(np.int64)
    return np.asarray(spoken[np.clip(rows, 0, len(spoken) - 1)])


def word_frames(group: tuple[str, ...]) -> Where:
    """Frames in some words."""
    return lambda corpus, clip: in_words(corpus.clips[clip].words, group, corpus.times(clip))


def phone_frames(phones: tuple[str, ...]) -> Where:
    """Frames of some phones and of their neighbours, without silence."""
    return lambda corpus, clip: near_phones(corpus.clips[clip].track, phones, corpus.times(clip))
