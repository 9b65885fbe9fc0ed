"""Decoders of the audio-driven regressors in NumPy: map audio features to modes of the face.

Medina (2023), sections 3.2.1.1 and 4.2. `_torch_audio` trains the same layers under the same names.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from phonanim.core.neural import tensors_with_prefix, transformer_block
from phonanim.regressors._audio_config import Settings
from phonanim.regressors._convolution import convolution_shapes, convolve
from phonanim.regressors._recurrent import recurrent_names, run_recurrent

Floats = NDArray[np.float32]
Shapes = dict[str, tuple[int, ...]]
GATES = {"gru": 3, "lstm": 4, "rnn": 1}
WIDER = 4  # width of the fully connected layers of a transformer, relative to its dims
OVERLAP = 3  # windows of a transformer that include each step


class Recurrence(Protocol):
    """The settings of recurrent layers."""

    @property
    def decoder(self) -> str:
        """One of GATES."""

    @property
    def hidden(self) -> int:
        """Units of a side of a layer."""

    @property
    def depth(self) -> int:
        """Number of layers."""

    @property
    def bidirectional(self) -> bool:
        """Whether a second side runs backwards."""


class Attention(Protocol):
    """The settings of transformer layers."""

    @property
    def hidden(self) -> int:
        """Features of each step."""

    @property
    def depth(self) -> int:
        """Number of layers."""

    @property
    def heads(self) -> int:
        """Heads of each layer."""

    @property
    def window(self) -> int:
        """Steps of a training window, each with its position."""


def decode(config: Settings, weights: Mapping[str, Floats], signal: Floats) -> Floats:
    """Run over sequences, (sequences, steps, dims) -> (sequences, steps, modes)."""
    if config.decoder == "mlp":
        return np.stack([_mlp(config, weights, one) for one in signal])
    if config.decoder == "transformer":
        return in_windows(
            weights, signal, lambda part: output(weights, attentive(config, weights, part), config.style)
        )
    if config.decoder == "convolution":
        return output(weights, convolve(config, weights, signal), config.style)
    for layer in range(config.depth):
        signal = run_recurrent(config.decoder, signal, weights, layer)
    return output(weights, signal, config.style)


def output(weights: Mapping[str, Floats], signal: Floats, style: int) -> Floats:
    """The factors of a style, if styles were learned, and the last layer, (..., size) -> (..., modes)."""
    if "style" in weights:
        signal = signal * weights["style"][style]
    return np.asarray(signal @ weights["output"] + weights["output_bias"])


def _mlp(config: Settings, weights: Mapping[str, Floats], signal: Floats) -> Floats:
    """Sliding windows over one sequence, (steps, dims) -> (steps, modes).

    The window of widths[0] steps that ends at a step predicts the last widths[1] steps; overlapping
    predictions are averaged (Taylor 2017, with windows that end where they predict by Medina 2023, 3.2.1.1).
    """
    wide, narrow = config.widths
    padded = np.pad(signal, ((wide - 1, 0), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, wide, axis=0).transpose(0, 2, 1)
    found = windows.reshape(len(windows), -1)
    for layer in range(config.depth):
        found = np.maximum(found @ weights[f"hidden{layer}"] + weights[f"hidden_bias{layer}"], 0)
    spans = output(weights, found, config.style).reshape(len(windows), narrow, -1)
    total, seen = np.zeros_like(spans[:, 0]), np.zeros((len(spans), 1), np.float32)
    for late in range(min(narrow, len(spans))):  # steps from a step to the end of the window that predicts it
        total[: len(spans) - late] += spans[late:, narrow - 1 - late]
        seen[: len(spans) - late] += 1
    return np.asarray(total / seen)


def in_windows(weights: Mapping[str, Floats], signal: Floats, run: Callable[[Floats], Floats]) -> Floats:
    """Attention within windows of the training length, because there are no positions beyond it.

    `run` maps (n, window, dims) to (n, window, size); windows overlap, and what they give is averaged.
    """
    wide, steps = len(weights["positions"]), signal.shape[1]
    signal = np.pad(signal, ((0, 0), (0, max(0, wide - steps)), (0, 0)), mode="edge")
    last = signal.shape[1] - wide
    starts = sorted({*range(0, last + 1, max(1, wide // OVERLAP)), last})
    total, seen = np.float32(0), np.zeros(signal.shape[1], np.float32)
    for start in starts:
        found = run(signal[:, start : start + wide])
        placed = ((0, 0), (start, signal.shape[1] - start - wide), (0, 0))
        total = total + np.pad(found, placed)
        seen[start : start + wide] += 1
    return np.asarray((total / seen[:, None])[:, :steps], np.float32)


def attentive(config: Attention, weights: Mapping[str, Floats], signal: Floats) -> Floats:
    """Embedding, positions and transformer layers, (n, window, dims) -> (n, window, size)."""
    signal = signal @ weights["embed"] + weights["embed_bias"] + weights["positions"]
    for layer in range(config.depth):
        signal = transformer_block(signal, tensors_with_prefix(weights, f"block{layer}_"), config.heads)
    return signal


def decoder_shapes(config: Settings, dims: int, modes: int) -> Shapes:
    """Name and shape of every weight of a decoder with `dims` input features."""
    known = {"mlp": _mlp_shapes, "transformer": transformer_shapes, "convolution": convolution_shapes}
    shapes, last = known.get(config.decoder, recurrent_shapes)(config, dims)
    outputs = modes * (config.widths[1] if config.decoder == "mlp" else 1)
    styles: Shapes = {"style": (config.styles, last)} if config.styles > 1 else {}
    return shapes | styles | {"output": (last, outputs), "output_bias": (outputs,)}


def recurrent_shapes(config: Recurrence, dims: int) -> tuple[Shapes, int]:
    sides, gates = 1 + config.bidirectional, GATES[config.decoder] * config.hidden
    shapes: Shapes = {}
    for layer in range(config.depth):
        shapes[f"forward{layer}"] = (sides, dims, gates)
        shapes[f"recur{layer}"] = (sides, config.hidden, gates)
        for name in recurrent_names(config.decoder)[2:]:
            shapes[f"{name}{layer}"] = (sides, gates)
        dims = sides * config.hidden
    return shapes, dims


def _mlp_shapes(config: Settings, dims: int) -> tuple[Shapes, int]:
    shapes: Shapes = {}
    before = dims * config.widths[0]
    for layer in range(config.depth):
        shapes[f"hidden{layer}"] = (before, config.hidden)
        shapes[f"hidden_bias{layer}"] = (config.hidden,)
        before = config.hidden
    return shapes, before


def transformer_shapes(config: Attention, dims: int) -> tuple[Shapes, int]:
    size = config.hidden
    shapes: Shapes = {"embed": (dims, size), "embed_bias": (size,)}
    shapes["positions"] = (config.window, size)
    for layer in range(config.depth):
        sizes = dict.fromkeys(("query", "key", "value", "out"), (size, size))
        sizes |= {"wide": (size, WIDER * size), "narrow": (WIDER * size, size)}
        for name, shape in sizes.items():
            shapes[f"block{layer}_{name}"] = shape
            shapes[f"block{layer}_{name}_bias"] = shape[1:]
        for name in ("norm1", "norm2"):
            shapes[f"block{layer}_{name}"] = shapes[f"block{layer}_{name}_bias"] = (size,)
    return shapes, size
