"""Recurrent network: a fully connected layer and two (bidirectional) LSTM layers over whole utterances.

After Fan et al. (2015), as Taylor 2017 (section 8.1) sets it up. Trained with torch, run in numpy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.features.inputs import STEP, inputs, n_features
from phonanim.features.windows import TICK
from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.regressors._rows import cluster_table
from phonanim.speech.inventory import N_PHONES
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
LAYERS = 2  # recurrent ones
PHASES = 8  # grids of the model's rate, 5 ms apart, between which instants are interpolated
TRIPHONE = 3 * N_PHONES + 2


@dataclass(frozen=True)
class Config:
    """Sizes, dropout and batch are the published ones; rate and epochs were chosen on validation clips.

    `features` is "triphone" (the contextual labels of Fan 2015: the phone at hand, the one before, the
    one after, and the place in it) or one of phonanim.features.inputs.FEATURES. `units` is the width of each
    layer; of a bidirectional one, half look back and half ahead. `batch` counts utterances.
    """

    features: str = "triphone"
    units: int = 500
    bidirectional: bool = True
    dropout: float = 0.5
    batch: int = 10
    rate: float = 2e-3
    epochs: int = 20
    patience: int = 5


@dataclass(frozen=True)
class Recurrent:
    """A trained network; every tensor of `weights` is named in `layer_shapes`, `clusters` (41, 41) int8."""

    config: Config
    weights: dict[str, Floats]
    clusters: NDArray[np.int8]

    input_modality: ClassVar[InputModality] = "phones"
    config_class: ClassVar[type] = Config

    def predict(self, track: PhoneTrack, times: Array, sound: Sound | None = None) -> Floats:
        """Modes at instants, (times,) seconds -> (times, modes).

        The network runs over the whole track on grids of the recordings' rate, PHASES of them side by
        side at most. Instants between two grids are interpolated, so that the motion is one function of
        continuous time and costs no more at odd frame rates.
        """
        place = np.clip(times, 0, track.duration) * PHASES / STEP
        below = np.floor(place + TICK).astype(np.int64)
        share = np.where(place - below < TICK * PHASES, 0, place - below)
        asked = np.concatenate([below, below + (share > 0)])
        phases, row = np.unique(asked % PHASES, return_inverse=True)
        # All of the track, whatever is asked for: one half of the network begins at the end.
        length = int(track.duration / STEP) + 2
        grid = np.arange(length) * STEP + phases[:, None] * STEP / PHASES
        found = self.forward(self._inputs(track, grid))[row, asked // PHASES]
        lower, upper = found[: len(times)], found[len(times) :]
        return np.asarray(lower + (upper - lower) * share[:, None], np.float32)

    def _inputs(self, track: PhoneTrack, grid: Array) -> Floats:
        rows = sequence(self.config.features, track, grid.ravel(), self.clusters)
        return rows.reshape(*grid.shape, n_inputs(self.config.features))

    def forward(self, signal: Floats) -> Floats:
        """Run over sequences, (sequences, frames, features) -> (sequences, frames, modes)."""
        signal = np.tanh(signal @ self.weights["input"] + self.weights["input_bias"])
        for layer in range(LAYERS):
            own = (self.weights[f"{part}{layer}"] for part in ("forward", "recur", "bias"))
            signal = recur(signal, *own)
        return np.asarray(signal @ self.weights["output"] + self.weights["output_bias"])

    def tensors(self) -> Tensors:
        """The weights of all layers and the clusters of phone pairs."""
        return {**self.weights, "clusters": self.clusters}

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> Recurrent:
        """Raises ValueError when a layer is not of the size that the configuration gives it."""
        weights = {}
        for name, shape in layer_shapes(config, len(tensors["output_bias"])).items():
            if tensors[name].shape != shape:
                raise ValueError(f"{name} is {tensors[name].shape}, not {shape}")
            weights[name] = tensors[name].astype(np.float32)
        return cls(config, weights, tensors["clusters"].astype(np.int8))

    @classmethod
    def fit(
        cls, config: Any, train: Examples, validation: Examples, rng: np.random.Generator, progress: Progress
    ) -> Recurrent:
        """Minimize the squared error of whole utterances; early stopping on `validation`."""
        from phonanim.regressors._torch import seeded
        from phonanim.regressors._torch_lstm import fit_recurrent

        clusters = cluster_table(config.features, train, rng)
        weights = fit_recurrent(config, train, validation, clusters, seeded(rng), progress)
        return cls(config, weights, clusters)


def sequence(features: str, track: PhoneTrack, times: Array, clusters: NDArray[np.int8]) -> Floats:
    """What the network sees at instants, (times,) seconds -> (times, features)."""
    return triphones(track, times) if features == "triphone" else inputs(features, track, times, clusters)


def n_inputs(features: str) -> int:
    """How many columns `sequence` has."""
    return TRIPHONE if features == "triphone" else n_features(features)


def triphones(track: PhoneTrack, times: Array) -> Floats:
    """Phones before, at and after instants as indicators, the share of the phone past, and its length.

    (times,) seconds -> (times, 125); the length in seconds, at most 1.
    """
    segment = track.segment_at(times + TICK)
    around = np.clip(segment[:, None] + np.array([-1, 0, 1]), 0, len(track.codes) - 1)
    found = np.zeros((len(times), TRIPHONE), np.float32)
    columns = track.codes[around] + np.arange(3) * N_PHONES
    np.put_along_axis(found, columns, np.float32(1), axis=1)
    length = np.diff(track.bounds)[segment]
    found[:, -2] = np.clip((times - track.bounds[segment]) / length, 0, 1)
    found[:, -1] = np.minimum(length, 1)
    return found


def layer_shapes(config: Config, modes: int) -> dict[str, tuple[int, ...]]:
    """Name and shape of every weight; the four gates of an LSTM (in, forget, cell, out) lie side by side."""
    sides = 1 + config.bidirectional
    size = config.units // sides
    shapes: dict[str, tuple[int, ...]] = {
        "input": (n_inputs(config.features), config.units),
        "input_bias": (config.units,),
    }
    for layer in range(LAYERS):
        before = config.units if layer == 0 else sides * size
        shapes[f"forward{layer}"] = (sides, before, 4 * size)
        shapes[f"recur{layer}"] = (sides, size, 4 * size)
        shapes[f"bias{layer}"] = (sides, 4 * size)
    return shapes | {"output": (sides * size, modes), "output_bias": (modes,)}


def recur(signal: Floats, forward: Floats, recurrent: Floats, bias: Floats) -> Floats:
    """One LSTM layer, (sequences, frames, before) -> (sequences, frames, sides * size).

    Side 0 runs from the first frame to the last, side 1, if there is one, back (Hochreiter and
    Schmidhuber 1997, with the forget gate of Gers 2000).
    """
    sides = len(forward)
    given = np.stack([signal, signal[:, ::-1]][:sides])
    given = given @ forward[:, None] + bias[:, None, None]
    count, frames, size = given.shape[1], given.shape[2], recurrent.shape[1]
    output = np.empty((sides, count, frames, size), np.float32)
    state, cell = np.zeros((2, sides, count, size), np.float32)
    for frame in range(frames):
        gates = given[:, :, frame] + state @ recurrent
        enter, forget, new, leave = np.split(gates, 4, axis=2)
        cell = _sigmoid(forget) * cell + _sigmoid(enter) * np.tanh(new)
        state = _sigmoid(leave) * np.tanh(cell)
        output[:, :, frame] = state
    if sides == 2:
        output[1] = output[1, :, ::-1].copy()
    return np.concatenate(list(output), axis=2)


def _sigmoid(signal: Floats) -> Floats:
    # Through tanh, which cannot overflow.
    return np.asarray((1 + np.tanh(signal * np.float32(0.5))) * np.float32(0.5))


REGRESSOR = Recurrent
