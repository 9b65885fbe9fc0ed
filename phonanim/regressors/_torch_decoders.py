"""The decoders of regressors/_decoders.py in torch, for training."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from phonanim.regressors._audio_config import Settings
from phonanim.regressors._convolution import convolution_shapes, steps_before
from phonanim.regressors._decoders import WIDER
from phonanim.regressors._torch import array, tensor
from phonanim.speech.inventory import N_PHONES

Floats = NDArray[np.float32]


class Network(nn.Module):
    """The mix of layers, a decoder, and the heads: modes, phones, phones with a blank."""

    def __init__(self, config: Settings, layers: int, dims: int, modes: int, labels: int = N_PHONES) -> None:
        super().__init__()
        self.config = config
        self.mix = nn.Parameter(torch.zeros(layers), requires_grad=config.inputs == "all_enc")
        self.body = _BODIES[config.decoder](config, dims)
        size = self.body.size
        self.narrow = config.widths[1] if config.decoder == "mlp" else 1
        self.dropout = nn.Dropout(config.dropout)
        self.style = nn.Parameter(torch.ones(config.styles, size)) if config.styles > 1 else None
        self.output = nn.Linear(size, modes * self.narrow)
        self.classifier = nn.Linear(size, labels)
        self.ctc = nn.Linear(size, labels + 1)

    def start_from(self, mean: Floats) -> None:
        """Start the output at the mean of the targets, (modes,), because steps of descent are short."""
        with torch.no_grad():
            self.output.bias.add_(tensor(np.tile(mean, self.narrow)))

    def forward(self, values: Tensor, styles: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """Normalized features (windows, steps, layers, dims) -> hidden (windows, steps, size), modes.

        `styles` (windows,) are used where styles are learned.
        """
        if self.config.inputs == "enc":
            signal = values[:, :, -1]
        else:
            signal = torch.einsum("bsld,l->bsd", values, torch.softmax(self.mix, 0))
        hidden: Tensor = self.dropout(self.body(signal))
        styled = hidden if self.style is None or styles is None else hidden * self.style[styles][:, None]
        found = self.output(styled)
        return hidden, _overlapped(found, self.narrow) if self.narrow > 1 else found


def _overlapped(spans: Tensor, narrow: int) -> Tensor:
    """Mean of the windows that predict each step, (n, steps, narrow * modes) -> (n, steps, modes).

    Windows beyond the end of a sequence are left out.
    """
    parts = spans.reshape(*spans.shape[:2], narrow, -1)
    total, seen = torch.zeros_like(parts[:, :, 0]), torch.zeros(spans.shape[1], 1, device=parts.device)
    for late in range(min(narrow, spans.shape[1])):
        total[:, : spans.shape[1] - late] += parts[:, late:, narrow - 1 - late]
        seen[: spans.shape[1] - late] += 1
    return total / seen


class Recurrent(nn.Module):
    """Layers of LSTM, GRU or plain recurrence."""

    def __init__(self, config: Settings, dims: int) -> None:
        super().__init__()
        kind = {"lstm": nn.LSTM, "rnn": nn.RNN}.get(config.decoder, nn.GRU)
        self.cells = kind(
            dims,
            config.hidden,
            config.depth,
            batch_first=True,
            bidirectional=config.bidirectional,
            dropout=config.dropout if config.depth > 1 else 0.0,
        )
        self.size = config.hidden * (1 + config.bidirectional)

    def forward(self, signal: Tensor) -> Tensor:
        """(windows, steps, dims) -> (windows, steps, size)."""
        found: Tensor = self.cells(signal)[0]
        return found

    def export(self) -> dict[str, Tensor]:
        """Weights by the names of `_decoders`; the sides of a bidirectional layer are stacked."""
        named: dict[str, Tensor] = dict(self.cells.named_parameters())
        found: dict[str, Tensor] = {}
        ends = ("", "_reverse") if self.cells.bidirectional else ("",)
        for layer in range(self.cells.num_layers):
            parts = [
                [named[f"{n}_l{layer}{e}"] for e in ends]
                for n in ("weight_ih", "weight_hh", "bias_ih", "bias_hh")
            ]
            found[f"forward{layer}"], found[f"recur{layer}"] = (
                torch.stack([weight.T for weight in sides]) for sides in parts[:2]
            )
            given, recurrent = (torch.stack(sides) for sides in parts[2:])
            if isinstance(self.cells, nn.GRU):
                found[f"bias{layer}"], found[f"recur_bias{layer}"] = given, recurrent
            else:
                found[f"bias{layer}"] = given + recurrent
        return found


class Windows(nn.Module):
    """Fully connected layers over windows that end at each step."""

    def __init__(self, config: Settings, dims: int) -> None:
        super().__init__()
        self.wide, self.size = config.widths[0], config.hidden
        sizes = [dims * self.wide, *[config.hidden] * config.depth]
        self.hidden = nn.ModuleList(nn.Linear(a, b) for a, b in pairwise(sizes))
        self.dropout = nn.Dropout(config.dropout)

    def forward(self, signal: Tensor) -> Tensor:
        """(windows, steps, dims) -> (windows, steps, size); the first step is repeated before the start."""
        before = signal[:, :1].expand(-1, self.wide - 1, -1)
        found = torch.cat([before, signal], dim=1).unfold(1, self.wide, 1).transpose(2, 3).flatten(2)
        for number, layer in enumerate(self.hidden):
            found = torch.relu(layer(self.dropout(found) if number else found))
        return found

    def export(self) -> dict[str, Tensor]:
        """Weights by the names of `_decoders`."""
        found: dict[str, Tensor] = {}
        for number, layer in enumerate(self.hidden):
            assert isinstance(layer, nn.Linear)
            found |= {f"hidden{number}": layer.weight.T, f"hidden_bias{number}": layer.bias}
        return found


class Attentive(nn.Module):
    """An embedding, learned positions, and transformer layers with normalization first."""

    def __init__(self, config: Settings, dims: int) -> None:
        super().__init__()
        self.size = config.hidden
        self.embed = nn.Linear(dims, self.size)
        self.positions = nn.Parameter(torch.randn(config.window, self.size) * 0.02)
        self.blocks = nn.ModuleList(
            nn.TransformerEncoderLayer(
                self.size,
                config.heads,
                WIDER * self.size,
                config.dropout,
                "gelu",
                batch_first=True,
                norm_first=True,
            )
            for _ in range(config.depth)
        )

    def forward(self, signal: Tensor) -> Tensor:
        """(windows, steps, dims) -> (windows, steps, size), with at most as many steps as positions."""
        found: Tensor = self.embed(signal) + self.positions[: signal.shape[1]]
        for block in self.blocks:
            found = block(found)
        return found

    def export(self) -> dict[str, Tensor]:
        """Weights by the names of `_decoders`."""
        found: dict[str, Tensor] = {"embed": self.embed.weight.T, "embed_bias": self.embed.bias}
        found["positions"] = self.positions
        for number, block in enumerate(self.blocks):
            found |= {f"block{number}_{name}": part for name, part in export_block(block).items()}
        return found


def export_block(block: nn.Module) -> dict[str, Tensor]:
    """Views of the weights of a transformer layer, by the names of `core.neural.transformer_block`."""
    assert isinstance(block, nn.TransformerEncoderLayer)
    attention = block.self_attn
    assert attention.in_proj_weight is not None
    assert attention.in_proj_bias is not None
    parts = dict(zip(("query", "key", "value"), attention.in_proj_weight.chunk(3), strict=True))
    biases = dict(zip(parts, attention.in_proj_bias.chunk(3), strict=True))
    for name, layer in (("out", attention.out_proj), ("wide", block.linear1), ("narrow", block.linear2)):
        parts[name], biases[name] = layer.weight, layer.bias
    for name, norm in (("norm1", block.norm1), ("norm2", block.norm2)):
        parts[name], biases[name] = norm.weight, norm.bias
    turned = {name: part.T if part.ndim == 2 else part for name, part in parts.items()}
    return turned | {f"{name}_bias": bias for name, bias in biases.items()}


class Convolved(nn.Module):
    """Convolutions over time, each with a rectifier and a normalization of channels."""

    def __init__(self, config: Settings, dims: int) -> None:
        super().__init__()
        shapes, self.size = convolution_shapes(config, dims)
        self.around = (steps_before(config), config.ahead)
        self.layers = nn.ModuleList(
            nn.Conv1d(shapes[f"kernel{n}"][1], shapes[f"kernel{n}"][2], kernel, dilation=dilation)
            for n, (kernel, dilation) in enumerate(zip(config.kernels, config.dilations, strict=True))
        )
        self.norms = nn.ModuleList(nn.LayerNorm(size) for size in config.channels)
        self.dropout = nn.Dropout(config.dropout)

    def forward(self, signal: Tensor) -> Tensor:
        """(windows, steps, dims) -> (windows, steps, size); clamped at the ends."""
        found = nn.functional.pad(signal.transpose(1, 2), self.around, mode="replicate").transpose(1, 2)
        for number, (layer, norm) in enumerate(zip(self.layers, self.norms, strict=True)):
            given = self.dropout(found) if number else found
            found = norm(torch.relu(layer(given.transpose(1, 2)).transpose(1, 2)))
        return found

    def export(self) -> dict[str, Tensor]:
        """Weights by the names of `_convolution`."""
        found: dict[str, Tensor] = {}
        for number, (layer, norm) in enumerate(zip(self.layers, self.norms, strict=True)):
            assert isinstance(layer, nn.Conv1d)
            assert isinstance(norm, nn.LayerNorm)
            assert layer.bias is not None
            found |= {f"kernel{number}": layer.weight.permute(2, 1, 0), f"bias{number}": layer.bias}
            found |= {f"norm{number}": norm.weight, f"norm_bias{number}": norm.bias}
        return found


Body = Recurrent | Windows | Attentive | Convolved
_BODIES: dict[str, type[Recurrent] | type[Windows] | type[Attentive] | type[Convolved]] = {
    "convolution": Convolved,
    "gru": Recurrent,
    "lstm": Recurrent,
    "mlp": Windows,
    "rnn": Recurrent,
    "transformer": Attentive,
}


def export_weights(network: Network, low: Floats, span: Floats) -> tuple[Floats, dict[str, Floats]]:
    """The mix and the decoder's weights as `_decoders` names them; targets are scaled back to millimetres."""
    span, low = np.tile(span, network.narrow), np.tile(low, network.narrow)
    parts = network.body.export()
    if network.style is not None:
        parts["style"] = network.style
    parts["output"] = network.output.weight.T * tensor(span)
    parts["output_bias"] = network.output.bias * tensor(span) + tensor(low)
    weights = {n: np.array(array(t), np.float32, order="C") for n, t in parts.items()}
    return array(network.mix).copy(), weights
