"""A regressor that holds the mean face of each phone while the phone lasts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.speech.inventory import N_PHONES
from phonanim.speech.phones import PhoneTrack


@dataclass(frozen=True)
class Config:
    """`gain` scales the motion around the mean face of all phones."""

    gain: float = 1.0


@dataclass(frozen=True)
class HeldMean:
    """`means` is (phones, modes); a phone that was never seen has the mean of all."""

    config: Config
    means: NDArray[np.float32]

    input_modality: ClassVar[InputModality] = "phones"
    config_class: ClassVar[type] = Config

    @classmethod
    def fit(
        cls, config: Any, train: Examples, validation: Examples, rng: np.random.Generator, progress: Progress
    ) -> HeldMean:
        """Average the frames of each phone."""
        codes = np.concatenate([t.sample(at) for t, at in zip(train.tracks, train.times, strict=True)])
        targets = np.concatenate(train.targets)
        means = np.tile(targets.mean(axis=0), (N_PHONES, 1))
        for code in np.unique(codes):
            means[code] = targets[codes == code].mean(axis=0)
        progress(1.0)
        return cls(config, means.astype(np.float32))

    def predict(
        self, track: PhoneTrack, times: NDArray[np.float64], sound: Sound | None = None
    ) -> NDArray[np.float32]:
        """Modes at instants, (times,) seconds -> (times, modes)."""
        middle = self.means.mean(axis=0)
        held = middle + self.config.gain * (self.means[track.sample(times)] - middle)
        return np.asarray(held, np.float32)

    def tensors(self) -> Tensors:
        """The means."""
        return {"means": self.means}

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> HeldMean:
        """The regressor of stored means. Raises KeyError when they are absent."""
        return cls(config, tensors["means"])


REGRESSOR = HeldMean
