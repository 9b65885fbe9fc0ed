"""Recurrent network: a fully connected layer and two (bidirectional) LSTM layers over whole utterances.

After Fan et al. (2015), with the setup of Taylor 2017 (section 8.1). Trained with torch, run in numpy.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.features.inputs import STEP
from phonanim.features.windows import TICK
from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.regressors._lstm_config import (
    LAYERS,
    Array,
    Config,
    Floats,
    n_columns,
    n_inputs,
    sequence_features,
)
from phonanim.regressors._recurrent import run_lstm
from phonanim.regressors._rows import cluster_table
from phonanim.regressors._styles import check_styles, layer_of_style, with_style
from phonanim.speech.phones import PhoneTrack

PHASES = 8  # grids at the model's rate, 5 ms apart, between which instants are interpolated


@dataclass(frozen=True)
class Recurrent:
    """A trained network; every tensor of `weights` is named in `layer_shapes`, `clusters` (41, 41) int8."""

    config: Config
    weights: dict[str, Floats]
    clusters: NDArray[np.int8]

    input_modality: ClassVar[InputModality] = "phones"
    config_class: ClassVar[type] = Config
    resumable: ClassVar[bool] = True

    def with_settings(self, **settings: Any) -> Recurrent:
        """The same network with another `style`. Raises ModelError for a style or setting that it lacks."""
        return with_style(self, settings)

    def predict(self, track: PhoneTrack, times: Array, sound: Sound | None = None) -> Floats:
        """Modes at instants, (times,) seconds -> (times, modes).

        The network runs over the whole track on at most PHASES grids at the recordings' rate. Instants
        between two grids are interpolated, so that the motion is one function of continuous time and odd
        frame rates cost no more.
        """
        place = np.clip(times, 0, track.duration) * PHASES / STEP
        below = np.floor(place + TICK).astype(np.int64)
        share = np.where(place - below < TICK * PHASES, 0, place - below)
        asked = np.concatenate([below, below + (share > 0)])
        phases, row = np.unique(asked % PHASES, return_inverse=True)
        # Always the whole track, because the backward half of the network starts at its end.
        length = int(track.duration / STEP) + 2
        grid = np.arange(length) * STEP + phases[:, None] * STEP / PHASES
        found = self.forward(self._inputs(track, grid))[row, asked // PHASES]
        lower, upper = found[: len(times)], found[len(times) :]
        return np.asarray(lower + (upper - lower) * share[:, None], np.float32)

    def _inputs(self, track: PhoneTrack, grid: Array) -> Floats:
        rows = sequence_features(self.config.features, track, grid.ravel(), self.clusters)
        return rows.reshape(*grid.shape, n_inputs(self.config.features))

    def forward(self, signal: Floats) -> Floats:
        """Run over sequences, (sequences, frames, features) -> (sequences, frames, modes)."""
        weights, bias = layer_of_style(self.weights["input"], self.weights["input_bias"], self.config)
        signal = np.tanh(signal @ weights + bias)
        for layer in range(LAYERS):
            own = (self.weights[f"{part}{layer}"] for part in ("forward", "recur", "bias"))
            signal = run_lstm(signal, *own)
        return np.asarray(signal @ self.weights["output"] + self.weights["output_bias"])

    def tensors(self) -> Tensors:
        """The weights of all layers and the clusters of phone pairs."""
        return {**self.weights, "clusters": self.clusters}

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> Recurrent:
        """Raises ValueError when the size of a layer does not match the configuration."""
        weights = {}
        for name, shape in layer_shapes(config, len(tensors["output_bias"])).items():
            if tensors[name].shape != shape:
                raise ValueError(f"{name} is {tensors[name].shape}, not {shape}")
            weights[name] = tensors[name].astype(np.float32)
        return cls(config, weights, tensors["clusters"].astype(np.int8))

    @classmethod
    def fit(
        cls,
        config: Any,
        train: Examples,
        validation: Examples,
        rng: np.random.Generator,
        progress: Progress,
        journal: Path | None = None,
    ) -> Recurrent:
        """Minimize the squared error of whole utterances; early stopping on `validation`.

        If `journal` is a folder, the state after each epoch is saved there, and an interrupted training is
        continued from it. Raises ModelError for a style beyond `styles`.
        """
        from phonanim.regressors._torch import seeded_generator
        from phonanim.regressors._torch_lstm import fit_recurrent

        check_styles("lstm", config.styles, train, validation)
        clusters = cluster_table(config.features, train, rng)
        weights = fit_recurrent(config, train, validation, clusters, seeded_generator(rng), progress, journal)
        return cls(config, weights, clusters)


def layer_shapes(config: Config, modes: int) -> dict[str, tuple[int, ...]]:
    """Name and shape of every weight; the four gates of an LSTM (in, forget, cell, out) are concatenated."""
    sides = 1 + config.bidirectional
    size = config.units // sides
    shapes: dict[str, tuple[int, ...]] = {
        "input": (n_columns(config), config.units),
        "input_bias": (config.units,),
    }
    for layer in range(LAYERS):
        before = config.units if layer == 0 else sides * size
        shapes[f"forward{layer}"] = (sides, before, 4 * size)
        shapes[f"recur{layer}"] = (sides, size, 4 * size)
        shapes[f"bias{layer}"] = (sides, 4 * size)
    return shapes | {"output": (sides * size, modes), "output_bias": (modes,)}


REGRESSOR = Recurrent
