"""The network of regressors/_diffusion.py in torch; imported by `fit` only."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from phonanim.regressors._audio_config import Settings
from phonanim.regressors._diffusion import CONVOLVED, POOLED, REACH, TAPS, time_waves
from phonanim.regressors._facediffuser_config import Config
from phonanim.regressors._steps import cached_encoder
from phonanim.regressors._torch import array, tensor
from phonanim.regressors._torch_decoders import Attentive, Recurrent
from phonanim.regressors._torch_tuned import Tuned

Floats = NDArray[np.float32]


class Network(nn.Module):
    """Estimates the motion from motion with noise, sound and time."""

    def __init__(self, config: Config, dims: int, modes: int) -> None:
        super().__init__()
        self.config = config
        encoder = cached_encoder(config.encoder) if config.tuned else None
        self.tuned = Tuned(encoder, config.tuned, config.dropout) if encoder else None
        self.sound = Embedding(config.sound, dims, config.latent)
        self.face = Embedding(config.sound, modes, self.sound.size) if config.autoencoder else None
        size = self.sound.size
        if config.diffusion:
            self.noise = Embedding(config.noise, modes, config.latent, over=config.noise_over)
            self.time = Embedding("mlp", config.latent, config.latent, nn.SiLU())
            size += self.noise.size + self.time.size
        self.body = _body(config, size)
        self.style = nn.Parameter(torch.ones(config.styles, self.body.size))
        self.dropout = nn.Dropout(config.dropout)
        self.output = nn.Linear(self.body.size, modes)
        if config.zero_output:
            nn.init.zeros_(self.output.weight)
            nn.init.zeros_(self.output.bias)

    def forward(self, audio: Tensor, noisy: Tensor, times: NDArray[np.int64], styles: Tensor) -> Tensor:
        """(n, steps, size), (n, steps, modes), (n,), (n,) -> (n, steps, modes)."""
        if self.config.diffusion:
            moment = self.time(tensor(time_waves(times, self.config.latent))[:, None])
            audio = torch.cat([audio, self.noise(noisy), moment.expand(-1, noisy.shape[1], -1)], dim=2)
        hidden = self.body(audio) * self.style[styles][:, None]
        found: Tensor = self.output(self.dropout(hidden))
        return found

    def export(self) -> dict[str, Floats]:
        """Weights by the names of `_diffusion`."""
        found = self.sound.export("sound_") | self.body.export()
        if self.config.diffusion:
            found |= self.noise.export("noise_") | self.time.export("time_")
        if self.tuned:
            found |= {f"tuned_{name}": part for name, part in self.tuned.export().items()}
        found |= {"style": self.style, "output": self.output.weight.T, "output_bias": self.output.bias}
        return {name: array(part).copy() for name, part in found.items()}


def _body(config: Config, dims: int) -> Recurrent | Attentive:
    settings: Any = Settings(
        decoder=config.decoder,  # type: ignore[arg-type]  # the configuration has checked it
        heads=config.heads,
        window=config.window,
        hidden=config.hidden,
        depth=config.depth,
        bidirectional=config.bidirectional,
        dropout=config.dropout,
    )
    return (Attentive if config.decoder == "transformer" else Recurrent)(settings, dims)


class Embedding(nn.Module):
    """One of _diffusion.EMBEDDINGS."""

    def __init__(
        self, kind: str, dims: int, size: int, active: nn.Module | None = None, over: str = "time"
    ) -> None:
        super().__init__()
        self.kind, self.size = kind, dims if kind == "none" else size
        self.over_features = over == "features" and kind in CONVOLVED
        self.active = active or nn.ReLU()
        wide = size * (POOLED if kind in ("max", "average") else 1)
        self.first = nn.Identity() if kind == "none" else nn.Linear(dims, size)
        self.second: nn.Module = nn.Identity()
        if self.over_features:
            self.first = nn.Linear(dims, wide)
            self.second = nn.Conv1d(1, 1, TAPS, padding="same")
        elif kind == "mlp":
            self.second = nn.Linear(size, size)
        elif kind not in ("none", "linear"):
            self.second = nn.Conv1d(size, wide, 2 * REACH + 1, padding=REACH)

    def forward(self, signal: Tensor) -> Tensor:
        """(n, steps, dims) -> (n, steps, size)."""
        found: Tensor = self.first(signal)
        if self.kind in ("none", "linear"):
            return found
        if self.over_features:
            found = torch.relu(self.second(found.flatten(0, 1)[:, None])[:, 0].unflatten(0, found.shape[:2]))
        else:
            found = self.active(found)
            if self.kind == "mlp":
                return torch.as_tensor(self.second(found))
            found = self.second(found.transpose(1, 2)).transpose(1, 2)
        if self.kind == "conv":
            return found
        pairs = found.reshape(*found.shape[:2], -1, POOLED)
        return pairs.amax(dim=3) if self.kind == "max" else pairs.mean(dim=3)

    def export(self, name: str) -> dict[str, Tensor]:
        """Weights by the names of `_diffusion`."""
        found: dict[str, Tensor] = {}
        for part, layer in (("first", self.first), ("second", self.second)):
            if isinstance(layer, (nn.Linear, nn.Conv1d)):
                assert layer.bias is not None
                weight = layer.weight.permute(*reversed(range(layer.weight.ndim)))
                alone = self.over_features and part == "second"
                found[f"{name}{part}"] = weight[:, 0, 0] if alone else weight
                found[f"{name}{part}_bias"] = layer.bias
        return found
