"""Common part of prediction and training of regressors/hmm.py: settings, and the questions about phones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import ModelError
from phonanim.regressors._styles import check_style
from phonanim.speech.inventory import INVENTORY, N_PHONES

LEAF = -1  # in `question`
CONTEXT = 2  # phones on either side
SLOWEST = 25.0  # frames per second
# Weights of the frames before, at and after: the value, its first and its second difference.
WINDOWS = np.array([[0.0, 1.0, 0.0], [-0.5, 0.0, 0.5], [1.0, -2.0, 1.0]])


@dataclass(frozen=True)
class Config:
    """`rate` is the models' frames per second: five states need more frames than a camera delivers.

    A node is split when both sides keep `leaf` frames and the likelihood grows by more than `mdl` times the
    minimum description length of another Gaussian (Shinoda and Watanabe 2000). A `mdl` above 1 accounts for
    neighbouring frames, which are nearly redundant. `alignments` is the number of Viterbi passes. `style` is
    the style of the output, out of the `styles` of Examples.styles, which differ in their mean.
    """

    states: int = 5
    rate: float = 200.0
    leaf: int = 50
    mdl: float = 1.0
    alignments: int = 2
    styles: int = 1
    style: int = 0

    def __post_init__(self) -> None:
        check_style("hmm", self)
        if self.rate < SLOWEST:
            raise ModelError(
                f"hmm: rate is {self.rate:g}; take {SLOWEST:g} or more, for states in short phones"
            )


def list_questions() -> tuple[NDArray[np.int8], NDArray[np.uint8]]:
    """All questions: is the phone at a place this one, or of this attribute class?

    Places (questions,) from 0, two phones before, to 4; members (questions, 41).
    """
    classes = np.vstack([np.eye(N_PHONES, dtype=np.uint8), INVENTORY.attributes.T.astype(np.uint8)])
    classes = np.unique(classes[classes.any(axis=1) & ~classes.all(axis=1)], axis=0)
    places = np.arange(2 * CONTEXT + 1, dtype=np.int8)
    return np.repeat(places, len(classes)), np.tile(classes, (len(places), 1))


def quinphones(codes: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Each phone with its neighbours, (segments,) -> (segments, 5); silence beyond the ends."""
    silence = np.full(CONTEXT, INVENTORY.code("sil"), np.uint8)
    whole = np.concatenate([silence, codes, silence])
    return np.lib.stride_tricks.sliding_window_view(whole, 2 * CONTEXT + 1)


def answer_questions(
    contexts: NDArray[np.uint8], place: NDArray[np.int8], members: NDArray[np.uint8]
) -> NDArray[np.bool_]:
    """The answers of quinphones (rows, 5) to every question, (rows, questions)."""
    return members[np.arange(len(members)), contexts[:, place]].astype(bool)
