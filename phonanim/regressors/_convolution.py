"""Convolutions over time in NumPy, with an exact receptive field per step, so that they can be streamed.

Medina (2023), section 5.4: blocks of a convolution, a rectifier and a normalization. Here the normalization
is over the channels of a step (Ba et al. 2016). With a normalization over time, as the group normalization of
the thesis, a step would depend on the whole sequence.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from phonanim.core.neural import layer_norm
from phonanim.errors import ModelError
from phonanim.regressors._audio_config import Settings

Floats = NDArray[np.float32]


def receptive_field(config: Settings) -> int:
    """Steps that affect one step: 1 + sum of (kernel - 1) * dilation (eq. 5.1, 5.2)."""
    return 1 + sum(reach for _, reach in _layers(config))


def steps_before(config: Settings) -> int:
    """Steps before a step that affect it."""
    return receptive_field(config) - 1 - config.ahead


def convolve(config: Settings, weights: Mapping[str, Floats], signal: Floats) -> Floats:
    """All layers, (sequences, steps, dims) -> (sequences, steps, channels); clamped at the ends."""
    around = ((0, 0), (steps_before(config), config.ahead), (0, 0))
    return convolve_within(config, weights, np.pad(signal, around, mode="edge"))


def convolve_within(config: Settings, weights: Mapping[str, Floats], signal: Floats) -> Floats:
    """All layers, (sequences, steps, dims) -> (sequences, steps - receptive field + 1, channels)."""
    for layer, (dilation, reach) in enumerate(_layers(config)):
        steps = signal.shape[1] - reach
        parts = [signal[:, shift : shift + steps] for shift in range(0, reach + 1, dilation)]
        kernel = weights[f"kernel{layer}"]
        found = np.concatenate(parts, axis=2) @ kernel.reshape(-1, kernel.shape[2]) + weights[f"bias{layer}"]
        found = np.maximum(found, 0)
        signal = layer_norm(found, weights[f"norm{layer}"], weights[f"norm_bias{layer}"])
    return np.asarray(signal)


def convolution_shapes(config: Settings, dims: int) -> tuple[dict[str, tuple[int, ...]], int]:
    """Shapes of all weights, and the number of output channels. Raises ModelError if layers do not match."""
    counts = {len(config.kernels), len(config.dilations), len(config.channels)}
    if len(counts) > 1 or not config.kernels:
        raise ModelError("kernels, dilations and channels differ in length; give each layer one of each")
    if not 0 <= config.ahead < receptive_field(config):
        most = receptive_field(config) - 1
        raise ModelError(f"ahead is {config.ahead} steps; these layers allow 0 to {most}")
    shapes: dict[str, tuple[int, ...]] = {}
    for layer, (size, channels) in enumerate(zip(config.kernels, config.channels, strict=True)):
        shapes[f"kernel{layer}"] = (size, dims, channels)
        for name in ("bias", "norm", "norm_bias"):
            shapes[f"{name}{layer}"] = (channels,)
        dims = channels
    return shapes, dims


def _layers(config: Settings) -> Iterator[tuple[int, int]]:
    """Dilation of each layer, and steps between its first and last input."""
    for kernel, dilation in zip(config.kernels, config.dilations, strict=True):
        yield dilation, (kernel - 1) * dilation
