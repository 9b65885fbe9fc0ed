"""Dominance functions, fitted: the procedural model of coarticulation.

After Cohen and Massaro (1993): every gesture i pulls each mode towards its own target, most strongly
while it lasts, with a dominance that decays before it (anticipation) and after it (carry-over):

    y_m(t) = c_m + sum_i w_im(t) T_im,   w_im = softmax_i( a_im + ln(d_i)/2 - (u/on_im + v/off_im)^k_m )

where u and v are the seconds by which t lies before and after the core of gesture i, d_i its duration.
Targets T, strengths a and time constants on, off are linear in the gestures' articulation, plus an
own part for gestures that the recordings hold: so a phone that was never recorded still has a mouth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.speech.gestures import GESTURES, split_parts
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
REACH = 5  # gestures on either side that can be felt
SHORT, LONG = 0.01, 0.2  # seconds; durations count for dominance between these
TABLES = ("target", "strength", "onset", "offset")


@dataclass(frozen=True)
class Config:
    """`own` and `shared` are the ridge penalties of a gesture's own part and of the articulation's."""

    steps: int = 600
    batch: int = 4096
    rate: float = 0.03
    own: float = 1e-2
    shared: float = 1e-4


@dataclass(frozen=True)
class Procedural:
    """Fitted dominance functions; `target`, `strength`, `onset`, `offset` are (gestures, modes)."""

    config: Config
    target: NDArray[np.float32]
    strength: NDArray[np.float32]
    onset: NDArray[np.float32]
    offset: NDArray[np.float32]
    exponent: NDArray[np.float32]
    rest: NDArray[np.float32]
    core: NDArray[np.float32]

    input_modality: ClassVar[InputModality] = "phones"
    config_class: ClassVar[type] = Config

    def predict(self, track: PhoneTrack, times: Array, sound: Sound | None = None) -> NDArray[np.float32]:
        """Modes at instants, (times,) seconds -> (times, modes)."""
        pieces = [self._predict(track, times[i : i + 4096]) for i in range(0, len(times), 4096)]
        return np.concatenate(pieces) if pieces else np.zeros((0, len(self.rest)), np.float32)

    def _predict(self, track: PhoneTrack, times: Array) -> NDArray[np.float32]:
        near = neighbours(track, times)
        middle, half = (near.begin + near.end) / 2, (near.end - near.begin) / 2 * self.core
        before = np.maximum(middle - half, 0)[..., None] / self.onset[near.gesture]
        after = np.maximum(-(middle + half), 0)[..., None] / self.offset[near.gesture]
        duration = np.log(np.clip(near.end - near.begin, SHORT, LONG)) / 2
        pull = self.strength[near.gesture] - (before + after + 1e-4) ** self.exponent + duration[..., None]
        pull = np.where(near.exists[..., None], pull, -1e9)
        weight = np.exp(pull - pull.max(axis=1, keepdims=True))
        weight /= weight.sum(axis=1, keepdims=True)
        moved = (weight * self.target[near.gesture]).sum(axis=1) + self.rest
        return np.asarray(moved, np.float32)

    def tensors(self) -> Tensors:
        """The tables and the constants, by name."""
        return {name: getattr(self, name) for name in (*TABLES, "exponent", "rest", "core")}

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> Procedural:
        """Raises ValueError when a table does not fit the gestures of lexicon/gestures.csv."""
        modes = len(tensors["rest"])
        for name in TABLES:
            if tensors[name].shape != (len(GESTURES.names), modes):
                raise ValueError(f"{name} is {tensors[name].shape}, not {(len(GESTURES.names), modes)}")
        return cls(config, **{name: tensors[name] for name in (*TABLES, "exponent", "rest", "core")})

    @classmethod
    def fit(
        cls, config: Any, train: Examples, validation: Examples, rng: np.random.Generator, progress: Progress
    ) -> Procedural:
        """Fit all tables by stochastic gradient descent on the squared error."""
        from phonanim.regressors._torch import fit_dominance

        return cls(config, **fit_dominance(config, train, rng, progress))


@dataclass(frozen=True)
class Neighbours:
    """The gestures around instants, each (times, 2 REACH + 1); `begin`, `end` in seconds from there."""

    gesture: NDArray[np.int64]
    begin: NDArray[np.float32]
    end: NDArray[np.float32]
    exists: NDArray[np.bool_]


def neighbours(track: PhoneTrack, times: Array) -> Neighbours:
    """The gestures that can be felt at instants, (times,) seconds."""
    parts = split_parts(track)
    here = np.clip(np.searchsorted(parts.bounds, times, side="right") - 1, 0, len(parts.parts) - 1)
    around = here[:, None] + np.arange(-REACH, REACH + 1)
    exists = (around >= 0) & (around < len(parts.parts))
    around = np.clip(around, 0, len(parts.parts) - 1)
    return Neighbours(
        GESTURES.part_gesture[parts.parts[around]],
        (parts.bounds[around] - times[:, None]).astype(np.float32),
        (parts.bounds[around + 1] - times[:, None]).astype(np.float32),
        exists,
    )


REGRESSOR = Procedural
