"""The last blocks of an encoder that are trained further with a model, in NumPy.

Stan (2023), section 8.1, trains HuBERT further but for its first layers. Here the blocks are those of
Whisper, HuBERT or wav2vec 2.0. They run at the encoder's own 50 steps a second.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from phonanim.core.neural import layer_norm, tensors_with_prefix, transformer_block
from phonanim.encoders import Encoder
from phonanim.encoders._transformers import Hidden
from phonanim.encoders.whisper import Whisper
from phonanim.errors import ModelError

Floats = NDArray[np.float32]
SQUARE = ("query", "key", "value", "out")
WIDER = 4  # width of the fully connected layers, relative to the dims


def last_blocks(encoder: Encoder, count: int) -> tuple[dict[str, Floats], int]:
    """The weights of an encoder's last blocks and of its final normalization, and the heads of a block.

    There is no final normalization (`norm`) where blocks normalize their sums, as those of HuBERT base.
    Raises ModelError for an encoder without such blocks, or with fewer.
    """
    if not isinstance(encoder, Whisper | Hidden):
        raise ModelError(
            "facediffuser: tuned needs the encoder whisper, hubert or wav2vec2, not "
            f"{encoder.identity.split()[0]}"
        )
    first = encoder.layers - 1 - count
    if first < 0:
        raise ModelError(f"facediffuser: tuned is {count}; the encoder has {encoder.layers - 1} blocks")
    found: dict[str, Floats] = {
        name: encoder.tensors[name] for name in ("norm", "norm_bias") if name in encoder.tensors
    }
    for number in range(count):
        block = tensors_with_prefix(encoder.tensors, f"block{first + number}_")
        block.setdefault("key_bias", np.zeros(encoder.dims, np.float32))
        found |= {f"block{number}_{name}": part for name, part in block.items()}
    if count and found["block0_wide"].shape != (encoder.dims, WIDER * encoder.dims):
        raise ModelError(f"facediffuser: tuned needs blocks that are {WIDER} times as wide inside")
    return found, encoder.heads


def run_blocks(weights: Mapping[str, Floats], count: int, heads: int, pairs: NDArray[np.floating]) -> Floats:
    """Pairs of an encoder's steps through its last blocks, (..., steps, 2 dims) -> the same."""
    signal = pairs.astype(np.float32).reshape(*pairs.shape[:-2], 2 * pairs.shape[-2], -1)
    first = "norm" in weights
    for number in range(count):
        signal = transformer_block(signal, tensors_with_prefix(weights, f"block{number}_"), heads, first)
    if first:
        signal = layer_norm(signal, weights["norm"], weights["norm_bias"])
    return np.asarray(signal).reshape(pairs.shape)


def block_shapes(count: int, size: int, norm_first: bool = True) -> dict[str, tuple[int, ...]]:
    """Name and shape of every weight of `count` blocks of `size` features.

    With `norm_first`, a final normalization follows.
    """
    if count == 0:
        return {}
    one: dict[str, tuple[int, ...]] = dict.fromkeys(SQUARE, (size, size))
    one |= {"wide": (size, WIDER * size), "narrow": (WIDER * size, size)}
    one |= {f"{name}_bias": shape[1:] for name, shape in one.items()}
    one |= dict.fromkeys(("norm1", "norm1_bias", "norm2", "norm2_bias"), (size,))
    shapes = {f"block{number}_{name}": shape for number in range(count) for name, shape in one.items()}
    return shapes | ({"norm": (size,), "norm_bias": (size,)} if norm_first else {})
