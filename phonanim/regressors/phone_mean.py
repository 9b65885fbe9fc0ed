"""The mean face of each phone, smoothed over time: the baseline without context."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.regressors._styles import (
    OffsetStyles,
    check_style,
    offset_tensors,
    read_offsets,
    split_offsets,
)
from phonanim.speech.inventory import N_PHONES
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Config:
    """`smoothing` is the width of the box, in seconds, over which the means are averaged.

    `style` is the style of the output, out of the `styles` of Examples.styles, which differ in their mean.
    """

    smoothing: float = 0.12
    styles: int = 1
    style: int = 0

    def __post_init__(self) -> None:
        check_style("phone_mean", self)


@dataclass(frozen=True)
class PhoneMean(OffsetStyles):
    """`means` (41, modes); phones that are not in the training data have the mean of all."""

    config: Config
    means: NDArray[np.float32]
    offsets: NDArray[np.float32] | None = None

    input_modality: ClassVar[InputModality] = "phones"
    config_class: ClassVar[type] = Config

    def predict(self, track: PhoneTrack, times: Array, sound: Sound | None = None) -> NDArray[np.float32]:
        """Modes at instants, (times,) seconds -> (times, modes): the exact mean over the box."""
        rows = self.means[track.codes].astype(np.float64)
        bounds = track.bounds.copy()
        bounds[0], bounds[-1] = -1.0, bounds[-1] + 1.0  # extend the first and last phone beyond the ends
        running = np.concatenate(
            [np.zeros((1, rows.shape[1])), np.cumsum(rows * np.diff(bounds)[:, None], axis=0)]
        )
        edges = times[:, None] + np.array([-0.5, 0.5]) * self.config.smoothing
        segment = np.clip(np.searchsorted(bounds, edges, side="right") - 1, 0, len(rows) - 1)
        integral = running[segment] + rows[segment] * (edges - bounds[segment])[..., None]
        found = np.asarray((integral[:, 1] - integral[:, 0]) / self.config.smoothing, np.float32)
        return self.in_style(found, self.offsets)

    def tensors(self) -> Tensors:
        """The means, and the offsets of styles."""
        return {"means": self.means} | offset_tensors(self.offsets)

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> PhoneMean:
        """Raises ValueError when `means` does not have one row for each phone."""
        if len(tensors["means"]) != N_PHONES:
            raise ValueError(f"means has {len(tensors['means'])} rows, not {N_PHONES}")
        means = tensors["means"]
        return cls(config, means, read_offsets(config.styles, means.shape[1], tensors))

    @classmethod
    def fit(
        cls, config: Any, train: Examples, validation: Examples, rng: np.random.Generator, progress: Progress
    ) -> PhoneMean:
        """Average the frames of each phone. Raises ModelError for a style beyond `styles`."""
        train, offsets = split_offsets("phone_mean", config.styles, train)
        codes = np.concatenate([t.sample(at) for t, at in zip(train.tracks, train.times, strict=True)])
        targets = np.concatenate(train.targets)
        means = np.tile(targets.mean(axis=0), (N_PHONES, 1))
        for code in np.unique(codes):
            means[code] = targets[codes == code].mean(axis=0)
        progress(1.0)
        return cls(config, means.astype(np.float32), offsets)


REGRESSOR = PhoneMean
