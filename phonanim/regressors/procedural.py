"""Dominance functions, fitted to recordings: the procedural model of coarticulation.

After Cohen and Massaro (1993): every gesture i pulls each mode towards its target, most strongly during the
gesture, with a dominance that decays before it (anticipation) and after it (carry-over):

    y_m(t) = c_m + sum_i w_im(t) T_im,   w_im = softmax_i( a_im + ln(d_i)/2 - (u/on_im + v/off_im)^k_m )

where u and v are the seconds by which t is before and after the core of gesture i, and d_i is its duration.
Targets T, strengths a and time constants on, off are linear in the gestures' articulation, plus an individual
part for gestures in the recordings. So a phone that is not in the recordings still has a mouth shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.regressors._procedural_config import LONG, SHORT, TABLES, Array, Config, neighbours
from phonanim.regressors._styles import OffsetStyles, offset_tensors, read_offsets, split_offsets
from phonanim.speech.gestures import GESTURES
from phonanim.speech.phones import PhoneTrack


@dataclass(frozen=True)
class Procedural(OffsetStyles):
    """Fitted dominance functions; `target`, `strength`, `onset`, `offset` are (gestures, modes)."""

    config: Config
    target: NDArray[np.float32]
    strength: NDArray[np.float32]
    onset: NDArray[np.float32]
    offset: NDArray[np.float32]
    exponent: NDArray[np.float32]
    rest: NDArray[np.float32]
    core: NDArray[np.float32]
    offsets: NDArray[np.float32] | None = None

    input_modality: ClassVar[InputModality] = "phones"
    config_class: ClassVar[type] = Config
    resumable: ClassVar[bool] = True

    def predict(self, track: PhoneTrack, times: Array, sound: Sound | None = None) -> NDArray[np.float32]:
        """Modes at instants, (times,) seconds -> (times, modes)."""
        pieces = [self._predict(track, times[i : i + 4096]) for i in range(0, len(times), 4096)]
        found = np.concatenate(pieces) if pieces else np.zeros((0, len(self.rest)), np.float32)
        return self.in_style(found, self.offsets)

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
        """The tables and the constants, and the offsets of styles, by name."""
        tables = {name: getattr(self, name) for name in (*TABLES, "exponent", "rest", "core")}
        return tables | offset_tensors(self.offsets)

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> Procedural:
        """Raises ValueError when a table does not match the gestures of lexicon/gestures.csv."""
        modes = len(tensors["rest"])
        for name in TABLES:
            if tensors[name].shape != (len(GESTURES.names), modes):
                raise ValueError(f"{name} is {tensors[name].shape}, not {(len(GESTURES.names), modes)}")
        tables = {name: tensors[name] for name in (*TABLES, "exponent", "rest", "core")}
        return cls(config, **tables, offsets=read_offsets(config.styles, modes, tensors))

    @classmethod
    def fit(
        cls,
        config: Any,
        train: Examples,
        validation: Examples,
        rng: np.random.Generator,
        progress: Progress,
        journal: Path | None = None,
    ) -> Procedural:
        """Fit all tables by stochastic gradient descent on the squared error.

        If `journal` is a folder, the state is saved there, and an interrupted training is continued from it.
        Raises ModelError for a style beyond `styles`.
        """
        from phonanim.regressors._torch import seeded_generator
        from phonanim.regressors._torch_procedural import fit_dominance

        train, offsets = split_offsets("procedural", config.styles, train)
        tables = fit_dominance(config, train, seeded_generator(rng), progress, journal)
        return cls(config, **tables, offsets=offsets)


REGRESSOR = Procedural
