"""The sliding-window network of Taylor 2017 (section 5.1), and smaller ones on other features."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.core.exact import ExactLayer, exact_layer
from phonanim.features.inputs import CONTEXT, STEP, n_features, window_features
from phonanim.features.overlaps import ContextLayer, context_layer
from phonanim.features.windows import predict_at
from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.regressors._dnn_config import Config
from phonanim.regressors._journal import end_parts, part_of
from phonanim.regressors._rows import cluster_table, training_rows
from phonanim.regressors._styles import check_styles, layer_of_style, style_columns, with_style
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Layers = tuple[tuple[NDArray[np.float32], NDArray[np.float32]], ...]
CHUNK = 384  # windows at once: small enough for the cache, large enough for the matrix product


@dataclass(frozen=True)
class Network:
    """Trained networks: the layers of each are (weights (in, out), bias (out,)), `clusters` (41, 41) int8."""

    config: Config
    networks: tuple[Layers, ...]
    clusters: NDArray[np.int8]

    input_modality: ClassVar[InputModality] = "phones"
    config_class: ClassVar[type] = Config
    resumable: ClassVar[bool] = True

    def with_settings(self, **settings: Any) -> Network:
        """The same networks with another `style`. Raises ModelError for a style or setting that they lack."""
        return with_style(self, settings)

    def predict(self, track: PhoneTrack, times: Array, sound: Sound | None = None) -> NDArray[np.float32]:
        """Modes at instants, (times,) seconds -> (times, modes); overlapping windows are averaged."""

        def windows(centres: Array) -> NDArray[np.float32]:
            return self._forward(track, centres).reshape(len(centres), self.config.width, -1)

        return predict_at(times, track.duration, STEP, self.config.width, windows, CHUNK)

    def _forward(self, track: PhoneTrack, times: Array) -> NDArray[np.float32]:
        """The mean answer of the networks, (times,) seconds -> (times, outputs)."""
        first, rest = self._exact
        shared = (
            first(track, times) if isinstance(first, ContextLayer) else first(self._features(track, times))
        )
        answers = []
        for signal, layers in zip(np.split(shared, len(rest), axis=1), rest, strict=True):
            for layer in layers:
                signal = layer(_ACTIVATIONS[self.config.activation](signal))
            answers.append(signal)
        return np.mean(answers, axis=0).astype(np.float32)

    def _features(self, track: PhoneTrack, times: Array) -> NDArray[np.float32]:
        return window_features(self.config.features, track, times, self.clusters, self.config.reach)

    @cached_property
    def _exact(self) -> tuple[ContextLayer | ExactLayer, list[list[ExactLayer]]]:
        """The first layers of all networks as one, because they have the same inputs; the others of each."""
        firsts = (layer_of_style(*one[0], self.config) for one in self.networks)
        weights, bias = (np.concatenate(parts, axis=-1) for parts in zip(*firsts, strict=True))
        context = self.config.features in CONTEXT
        first = context_layer(self.config.features, weights, bias) if context else exact_layer(weights, bias)
        return first, [[exact_layer(*layer) for layer in layers[1:]] for layers in self.networks]

    def tensors(self) -> Tensors:
        """weights0, bias0, weights1, ... (0.weights0, ... of several networks), and the clusters of pairs."""
        found: Tensors = {"clusters": self.clusters}
        for prefix, layers in zip(_prefixes(self.config), self.networks, strict=True):
            for number, (weights, bias) in enumerate(layers):
                found |= {f"{prefix}weights{number}": weights, f"{prefix}bias{number}": bias}
        return found

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> Network:
        """Raises ValueError when a layer does not match the one before it."""
        networks = tuple(_layers(config, tensors, prefix) for prefix in _prefixes(config))
        return cls(config, networks, tensors["clusters"].astype(np.int8))

    @classmethod
    def fit(
        cls,
        config: Any,
        train: Examples,
        validation: Examples,
        rng: np.random.Generator,
        progress: Progress,
        journal: Path | None = None,
    ) -> Network:
        """Minimize the squared error of the windows; early stopping on `validation`.

        If `journal` is a folder, the state after each epoch is saved there, in a folder for each network, and
        an interrupted training is continued from it. Raises ModelError for a style beyond `styles`.
        """
        from phonanim.regressors._torch import seeded_generator
        from phonanim.regressors._torch_dnn import Rows, fit_network

        check_styles("dnn", config.styles, train, validation)
        clusters = cluster_table(config.features, train, rng)
        settings = config.features, config.width, clusters, config.reach, config.styles
        rows, held_out = (Rows(*training_rows(part, *settings)) for part in (train, validation))
        networks = []
        for number in range(config.networks):

            def share(done: float, number: int = number) -> None:
                progress((number + done) / config.networks)

            own = part_of(journal, f"network{number}" if config.networks > 1 else "")
            networks.append(tuple(fit_network(config, rows, held_out, seeded_generator(rng), share, own)))
        if config.networks > 1:
            end_parts(journal, [f"network{number}" for number in range(config.networks)])
        return cls(config, tuple(networks), clusters)


def _prefixes(config: Config) -> list[str]:
    return [f"{number}." for number in range(config.networks)] if config.networks > 1 else [""]


def _layers(config: Config, tensors: Tensors, prefix: str) -> Layers:
    size, layers = n_features(config.features, config.reach) + style_columns(config.styles), []
    for number in range(len(config.hidden) + 1):
        weights, bias = tensors[f"{prefix}weights{number}"], tensors[f"{prefix}bias{number}"]
        if weights.shape != (size, len(bias)):
            raise ValueError(f"{prefix}weights{number} is {weights.shape}, not {(size, len(bias))}")
        size = len(bias)
        layers.append((weights.astype(np.float32), bias.astype(np.float32)))
    return tuple(layers)


def _silu(signal: Array) -> NDArray[np.float32]:
    # x * sigmoid(x) through tanh, which numpy vectorizes and which cannot overflow.
    half = signal.astype(np.float32)
    half *= np.float32(0.5)
    grown: NDArray[np.float32] = np.tanh(half)
    grown += 1
    grown *= half
    return grown


def _tanh(signal: Array) -> NDArray[np.float32]:
    return np.asarray(np.tanh(signal.astype(np.float32)), np.float32)


_ACTIVATIONS = {"silu": _silu, "tanh": _tanh}

REGRESSOR = Network
