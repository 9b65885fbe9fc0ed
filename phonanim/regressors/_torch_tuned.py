"""The last blocks of an encoder in torch, which start from its weights; imported by `fit` only."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from phonanim.encoders import Encoder
from phonanim.regressors._torch_decoders import export_block
from phonanim.regressors._tuned import WIDER, last_blocks

Floats = NDArray[np.float32]


class Tuned(nn.Module):
    """Blocks, and the final normalization where they normalize first; see `_tuned.run_blocks`."""

    def __init__(self, encoder: Encoder, count: int, dropout: float) -> None:
        super().__init__()
        weights, heads = last_blocks(encoder, count)
        size, first = encoder.dims, "norm" in weights
        self.blocks = nn.ModuleList(
            nn.TransformerEncoderLayer(
                size, heads, WIDER * size, dropout, "gelu", batch_first=True, norm_first=first
            )
            for _ in range(count)
        )
        self.norm = nn.LayerNorm(size) if first else None
        with torch.no_grad():
            if self.norm is not None:
                self.norm.weight.copy_(torch.from_numpy(weights["norm"]))
                self.norm.bias.copy_(torch.from_numpy(weights["norm_bias"]))
            for number, block in enumerate(self.blocks):
                for name, part in export_block(block).items():
                    part.copy_(torch.from_numpy(weights[f"block{number}_{name}"]))

    def forward(self, pairs: Tensor) -> Tensor:
        """(n, steps, 2 dims) -> the same."""
        signal = pairs.reshape(len(pairs), 2 * pairs.shape[1], -1)
        for block in self.blocks:
            signal = block(signal)
        found: Tensor = signal if self.norm is None else self.norm(signal)
        return found.reshape(pairs.shape)

    def export(self) -> dict[str, Tensor]:
        """Weights by the names of `_tuned`."""
        found: dict[str, Tensor] = {}
        if self.norm is not None:
            found = {"norm": self.norm.weight, "norm_bias": self.norm.bias}
        for number, block in enumerate(self.blocks):
            found |= {f"block{number}_{name}": part for name, part in export_block(block).items()}
        return found
