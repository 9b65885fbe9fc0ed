"""The network that recognizes phones: convolutions over time, in NumPy, each step as its input comes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError, read_tensors
from phonanim.errors import ModelError
from phonanim.recognition.spectrum import BANDS
from phonanim.speech.inventory import N_PHONES

Floats = NDArray[np.float32]
Tensors = Mapping[str, NDArray[Any]]

FAR = 200  # steps from the present that a layer may look at


@dataclass(frozen=True)
class Layer:
    """`weights` (len(offsets) * inputs, outputs) of the steps at `offsets` from the present; and `bias`."""

    offsets: tuple[int, ...]
    weights: Floats
    bias: Floats

    @property
    def inputs(self) -> int:
        """Number of values of a step that come in."""
        return len(self.weights) // len(self.offsets)


@dataclass(frozen=True)
class Network:
    """Layers, the last of them without rectification; and what the decoder uses.

    `prior` (phones,) is the log share of each phone, `follows` (phones, phones) the log probability that one
    follows another.
    """

    layers: tuple[Layer, ...]
    prior: Floats
    follows: Floats

    @property
    def ahead(self) -> int:
        """Steps of input after a step that it needs."""
        return sum(max(layer.offsets) for layer in self.layers)


@dataclass
class LayerStream:
    """A layer over steps that arrive. Before the first and after the last step, its input is 0."""

    layer: Layer
    waiting: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.waiting = np.zeros((-min(self.layer.offsets), self.layer.inputs), np.float32)

    def push(self, steps: Floats, last: bool) -> Floats:
        """(steps, inputs) -> the steps that are decided, (steps, outputs), without rectification."""
        offsets = np.array(self.layer.offsets) - min(self.layer.offsets)
        padding = np.zeros((max(self.layer.offsets) * last, self.layer.inputs), np.float32)
        self.waiting = np.concatenate([self.waiting, steps, padding])
        count = max(len(self.waiting) - int(offsets[-1]), 0)
        around = np.concatenate([self.waiting[start : start + count] for start in offsets], axis=1)
        # One product a step, so that a step has the same bytes however many come together.
        found = np.matmul(around[:, None], self.layer.weights)[:, 0] + self.layer.bias
        if found.shape[1] == self.layer.inputs:
            found += self.waiting[-min(self.layer.offsets) :][:count]
        self.waiting = self.waiting[count:]
        return np.asarray(found, np.float32)


@dataclass
class NetworkStream:
    """A network over steps that arrive: log probabilities of phones."""

    network: Network
    layers: list[LayerStream] = field(init=False)

    def __post_init__(self) -> None:
        self.layers = [LayerStream(layer) for layer in self.network.layers]

    def push(self, steps: Floats, last: bool = False) -> Floats:
        """Input (steps, bands) -> log probabilities of decided steps, (steps, phones)."""
        *hidden, final = self.layers
        for layer in hidden:
            steps = np.maximum(layer.push(steps, last), 0)
        scores = final.push(steps, last)
        raised = scores - scores.max(axis=1, keepdims=True)
        return np.asarray(raised - np.log(np.exp(raised).sum(axis=1, keepdims=True)), np.float32)


def network_from(tensors: Tensors, where: str) -> Network:
    """The network that tensors describe. Raises ModelError when they do not match."""
    layers: list[Layer] = []
    try:
        while f"weights{len(layers)}" in tensors:
            number = len(layers)
            offsets = tuple(int(offset) for offset in tensors[f"offsets{number}"].ravel())
            weights, bias = (tensors[f"{name}{number}"].astype(np.float32) for name in ("weights", "bias"))
            layers.append(Layer(offsets, weights, bias))
        prior, follows = (tensors[name].astype(np.float32) for name in ("prior", "follows"))
    except (KeyError, ValueError, OverflowError) as error:
        raise ModelError(f"{where}: is damaged ({error}); install phonanim again") from error
    finite = all(np.isfinite(tensor).all() for tensor in tensors.values() if tensor.dtype.kind == "f")
    if not layers or not finite or follows.shape != (N_PHONES, N_PHONES) or not _fit(layers, prior):
        raise ModelError(f"{where}: its tensors do not match; install phonanim again")
    return Network(tuple(layers), prior, follows)


def _fit(layers: list[Layer], prior: Floats) -> bool:
    """Whether each layer takes what the one before it gives, and the last gives phones."""
    width = BANDS
    for layer in layers:
        offsets = layer.offsets
        if (
            not offsets
            or list(offsets) != sorted(set(offsets))
            or not -FAR <= offsets[0] <= 0 <= offsets[-1] <= FAR
        ):
            return False
        if layer.weights.ndim != 2 or len(layer.weights) != width * len(offsets):
            return False
        width = layer.weights.shape[1]
        if layer.bias.shape != (width,):
            return False
    return width == N_PHONES and prior.shape == (width,)


@lru_cache(maxsize=2)
def load_network(path: Path) -> Network:
    """Read a network. Raises ModelError."""
    try:
        return network_from(read_tensors(path), str(path))
    except (OSError, DecodeError, ValueError) as error:
        raise ModelError(f"{path}: cannot be read ({error}); install phonanim again") from error
