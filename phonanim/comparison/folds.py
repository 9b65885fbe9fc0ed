"""The clips for training and for testing: test clips, withheld words and phones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim import metrics
from phonanim.comparison.plan import Plan
from phonanim.corpus.corpus import Corpus
from phonanim.speech.inventory import INVENTORY

Where = Callable[[Corpus, int], NDArray[np.bool_]]  # corpus, clip -> (frames,)


@dataclass(frozen=True)
class Fold:
    """`test` clips of a fold `name`, which are scored after training on `train`; `where`: frames by name."""

    name: str
    train: NDArray[np.int64]
    test: NDArray[np.int64]
    where: dict[str, Where]

    @property
    def face_clips(self) -> tuple[int, ...]:
        """The clips of the fold's reference face: its training clips, none of the withheld ones."""
        return tuple(self.train.tolist())


def make_folds(plan: Plan, corpus: Corpus) -> Iterator[Fold]:
    """Every fold of a plan. Every third clip with a withheld word is tested, every second with a phone."""
    train = corpus.clips_of("train")
    if "test" in plan.folds or "ema" in plan.folds:
        yield Fold("test", train, corpus.clips_of("test"), {"all": all_frames, "speech": speech_frames})
    for number, group in enumerate(plan.words if "words" in plan.folds else ()):
        holds = np.array([any(w.label in group for w in corpus.words[c]) for c in train])
        where = {"clip": speech_frames, "word": word_frames(group)}
        yield Fold(f"words{number + 1}", train[~holds], train[holds][::3], where)
    if "phones" in plan.folds and plan.phones:
        codes = INVENTORY.codes(plan.phones)
        holds = np.array([np.isin(corpus.tracks[c].codes, codes).any() for c in train])
        where = {"near": phone_frames(plan.phones)}
        yield Fold("phones", train[~holds], train[holds][::2], where)


def all_frames(corpus: Corpus, clip: int) -> NDArray[np.bool_]:
    """All frames of a clip."""
    return np.ones(int(corpus.frames[clip]), bool)


def speech_frames(corpus: Corpus, clip: int) -> NDArray[np.bool_]:
    """Frames of a clip that are speech."""
    return metrics.speech_mask(corpus.tracks[clip], corpus.times(clip))


def word_frames(group: tuple[str, ...]) -> Where:
    """Frames in some words."""

    def where(corpus: Corpus, clip: int) -> NDArray[np.bool_]:
        times = corpus.times(clip)
        inside = [(times >= w.start) & (times < w.end) for w in corpus.words[clip] if w.label in group]
        return np.any([np.zeros(len(times), bool), *inside], axis=0)

    return where


def phone_frames(phones: tuple[str, ...]) -> Where:
    """Frames of some phones and of their neighbours, without silence."""

    def where(corpus: Corpus, clip: int) -> NDArray[np.bool_]:
        track = corpus.tracks[clip]
        chosen = np.isin(track.codes, INVENTORY.codes(phones))
        beside = np.append(False, chosen[:-1]) | np.append(chosen[1:], False)
        segments = track.segment_at(corpus.times(clip))
        return (chosen | beside)[segments] & speech_frames(corpus, clip)

    return where
