"""The clips for training and for testing: test clips, withheld words and phones."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim import metrics
from phonanim.comparison.plan import LEFT_OUT, Plan
from phonanim.corpus.corpus import Corpus
from phonanim.errors import ModelError
from phonanim.speech.alignment import Interval
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

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
    """Every fold of a plan. Every third clip with a withheld word is tested, every second with a phone.

    Raises ModelError for a fold of other corpora.
    """
    if LEFT_OUT in plan.folds:
        raise ModelError(
            f"{plan.corpus}: folds: {LEFT_OUT!r} leaves out each clip of a corpus of controls, sensors or "
            'vertices; for landmarks use "test"'
        )
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
    return lambda corpus, clip: in_words(corpus.words[clip], group, corpus.times(clip))


def in_words(
    words: Sequence[Interval], group: tuple[str, ...], times: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Whether instants are in some words, (frames,)."""
    inside = [(times >= w.start) & (times < w.end) for w in words if w.label in group]
    return np.asarray(np.any([np.zeros(len(times), bool), *inside], axis=0))


def phone_frames(phones: tuple[str, ...]) -> Where:
    """Frames of some phones and of their neighbours, without silence."""
    return lambda corpus, clip: near_phones(corpus.tracks[clip], phones, corpus.times(clip))


def near_phones(track: PhoneTrack, phones: tuple[str, ...], times: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether instants are in some phones or in their neighbours, silence left out, (frames,)."""
    chosen = np.isin(track.codes, INVENTORY.codes(phones))
    beside = np.append(False, chosen[:-1]) | np.append(chosen[1:], False)
    return np.asarray((chosen | beside)[track.segment_at(times)] & metrics.speech_mask(track, times))
