"""Building blocks of neural networks in NumPy, for models that run without torch."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
EPSILON = 1e-5  # of every layer normalization here

# Abramowitz and Stegun 7.1.26: erf within 1.5e-7, the precision of float32.
_ERF = (1.061405429, -1.453152027, 1.421413741, -0.284496736, 0.254829592)


def gelu(signal: Floats) -> Floats:
    """A signal times the normal distribution function at it (Hendrycks and Gimpel 2016), any shape."""
    scaled = np.abs(signal) * np.float32(np.sqrt(0.5))
    t = 1 / (1 + np.float32(0.3275911) * scaled)
    tail = np.zeros_like(t)
    for weight in _ERF:
        tail = (tail + np.float32(weight)) * t
    tail *= np.exp(-scaled * scaled) * np.float32(0.5)
    return np.asarray(signal * np.where(signal < 0, tail, 1 - tail), np.float32)


def sigmoid(signal: Floats) -> Floats:
    """1 / (1 + exp(-x)), computed with tanh, which cannot overflow."""
    return np.asarray((1 + np.tanh(signal * np.float32(0.5))) * np.float32(0.5))


def softmax(signal: Floats) -> Floats:
    """Shares that sum to 1 along the last axis."""
    raised = np.exp(signal - signal.max(axis=-1, keepdims=True))
    return np.asarray(raised / raised.sum(axis=-1, keepdims=True))


def layer_norm(signal: Floats, scale: Floats, bias: Floats) -> Floats:
    """Normalize the last axis to mean 0 and deviation 1, then scale and shift it (Ba et al. 2016)."""
    centred = signal - signal.mean(axis=-1, keepdims=True)
    deviation = np.sqrt((centred**2).mean(axis=-1, keepdims=True) + np.float32(EPSILON))
    return np.asarray(centred / deviation * scale + bias)


def attend(query: Floats, key: Floats, value: Floats, heads: int) -> Floats:
    """Scaled dot-product attention of several heads, (..., steps, dims) each -> (..., steps, dims).

    softmax(Q K^T / sqrt(d)) V for each head's d dims (Vaswani et al. 2017; Medina 2023, eq. 3.1).
    """
    *rest, steps, dims = query.shape
    q, k, v = (part.reshape(*rest, -1, heads, dims // heads).swapaxes(-2, -3) for part in (query, key, value))
    weights = softmax(q @ k.swapaxes(-1, -2) * np.float32((dims // heads) ** -0.5))
    return np.asarray((weights @ v).swapaxes(-2, -3).reshape(*rest, steps, dims))


def transformer_block(
    signal: Floats, part: Mapping[str, Floats], heads: int, norm_first: bool = True
) -> Floats:
    """Self-attention and two fully connected layers, each on the normalized signal and added to it.

    (..., steps, dims) -> the same; `part` holds norm1, query, key, value, out, norm2, wide and narrow, and
    NAME_bias of each (that of key may be absent). Without `norm_first` the sums are normalized instead.
    """
    normal = layer_norm(signal, part["norm1"], part["norm1_bias"]) if norm_first else signal
    query, key, value = (normal @ part[n] + part.get(f"{n}_bias", 0) for n in ("query", "key", "value"))
    signal = signal + attend(query, key, value, heads) @ part["out"] + part["out_bias"]
    if not norm_first:
        signal = layer_norm(signal, part["norm1"], part["norm1_bias"])
    normal = layer_norm(signal, part["norm2"], part["norm2_bias"]) if norm_first else signal
    wide = gelu(normal @ part["wide"] + part["wide_bias"])
    signal = np.asarray(signal + wide @ part["narrow"] + part["narrow_bias"])
    return signal if norm_first else layer_norm(signal, part["norm2"], part["norm2_bias"])


def tensors_with_prefix(tensors: Mapping[str, Floats], prefix: str) -> dict[str, Floats]:
    """The tensors whose names begin with a prefix, without it."""
    return {name.removeprefix(prefix): t for name, t in tensors.items() if name.startswith(prefix)}
