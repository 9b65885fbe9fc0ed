"""Whisper's encoder (Radford et al. 2022) in NumPy, with all its layers, for weights of any size."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from phonanim.core.neural import gelu, layer_norm, tensors_with_prefix, transformer_block
from phonanim.encoders._weights import whisper_tensors
from phonanim.media.mel import whisper_mel

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Whisper:
    """The encoder with its weights, named as `encoders._weights` names them.

    Layer 0 is the sum of the convolutions and the positions, layer i the output of block i. The last layer
    includes the final normalization, as in the input of Whisper's decoder.
    """

    tensors: dict[str, Floats]
    heads: int
    identity: str
    start: float = 0.0
    window: int = 12
    margin: int = 1

    @cached_property
    def layers(self) -> int:
        """Number of blocks, plus one for the input of the first block."""
        return 1 + sum(name.endswith("query") for name in self.tensors)

    @property
    def dims(self) -> int:
        """384 for the tiny model."""
        return self.tensors["positions"].shape[1]

    def run(self, samples: Floats) -> Floats:
        """Features of (steps * HOP,) samples -> (steps, layers, dims)."""
        signal = gelu(_convolve(self.log_mel(samples), self.tensors["conv1"], 1) + self.tensors["conv1_bias"])
        signal = gelu(_convolve(signal, self.tensors["conv2"], 2) + self.tensors["conv2_bias"])
        signal = signal + self.tensors["positions"][: len(signal)]
        found = [signal]
        for number in range(self.layers - 1):
            signal = transformer_block(
                signal, tensors_with_prefix(self.tensors, f"block{number}_"), self.heads
            )
            found.append(signal)
        found[-1] = layer_norm(signal, self.tensors["norm"], self.tensors["norm_bias"])
        return np.stack(found, axis=1)

    def log_mel(self, samples: Floats) -> Floats:
        """The input of Whisper for (samples,) at 16 kHz: (frames, mels) at 100 Hz, about -1 to 1."""
        return whisper_mel(samples, self.tensors["conv1"].shape[1])


def _convolve(signal: Floats, kernel: Floats, stride: int) -> Floats:
    """Convolution of width 3 with zeros at the ends, (steps, in) by (3, in, out) -> (steps / stride, out)."""
    padded = np.pad(signal, ((1, 1), (0, 0)))
    taps = [padded[tap : tap + len(signal) : stride] for tap in range(3)]
    return np.asarray(np.concatenate(taps, axis=1) @ kernel.reshape(-1, kernel.shape[2]))


def load() -> Whisper:
    """The encoder with the weights that are found. Raises ModelError, which says how to get them."""
    tensors, heads, identity = whisper_tensors()
    return Whisper(tensors, heads, identity)
