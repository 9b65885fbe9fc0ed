"""Gradient descent for regressors/lstm.py; imported by its `fit` only."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from phonanim.regressors import Examples, Progress
from phonanim.regressors._lstm_config import LAYERS, Config, Floats, n_columns, sequence_features
from phonanim.regressors._styles import add_style, styles_of
from phonanim.regressors._torch import array, device, mixed_precision, tensor
from phonanim.regressors._torch_journal import State, state_key

LONGEST_STEP = 1.0  # largest norm of a gradient, because gradients of recurrent layers explode


class Network(nn.Module):
    """The layers of Taylor 2017, section 8.1, with dropout after each of the three hidden ones."""

    def __init__(self, config: Config, modes: int) -> None:
        super().__init__()
        size = config.units // (1 + config.bidirectional)
        wide = size * (1 + config.bidirectional)
        self.input = nn.Linear(n_columns(config), config.units)
        self.recurrent = nn.ModuleList(
            nn.LSTM(
                config.units if n == 0 else wide, size, batch_first=True, bidirectional=config.bidirectional
            )
            for n in range(LAYERS)
        )
        self.output = nn.Linear(wide, modes)
        self.dropout = nn.Dropout(config.dropout)

    def forward(self, signal: Tensor) -> Tensor:
        signal = self.dropout(torch.tanh(self.input(signal)))
        for layer in self.recurrent:
            signal = self.dropout(layer(signal)[0])
        found: Tensor = self.output(signal)
        return found


def fit_recurrent(
    config: Config,
    train: Examples,
    validation: Examples,
    clusters: NDArray[np.int8],
    generator: torch.Generator,
    progress: Progress,
    journal: Path | None = None,
) -> dict[str, Floats]:
    """Train on whole utterances with Adam; returns the weights that regressors/lstm.py names.

    The weights with the least validation error are kept; training ends after `patience` epochs without
    improvement. An interrupted training is continued from `journal`.
    """
    every = np.concatenate(train.targets)
    centre, spread = every.mean(axis=0), float(every.std())
    padded = pad_sequences(config, train, clusters)
    data = [tensor(a) for a in padded]
    held_out = [tensor(a) for a in pad_sequences(config, validation, clusters)] if len(validation) else []
    network = Network(config, every.shape[1]).to(device())
    optimizer = torch.optim.Adam(network.parameters(), lr=config.rate)
    batches = -(-len(train) // config.batch)
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimizer, config.rate, total_steps=max(1, config.epochs * batches)
    )
    middle = tensor(centre)
    key = state_key(config, generator.initial_seed(), padded if journal else ())
    state = State(network, optimizer, [], [], key, journal, schedule, generator, keep_first=True)
    state.resume()
    while not state.ended(config):
        network.train()
        losses = []
        for rows in torch.split(torch.randperm(len(train), generator=generator), config.batch):
            with mixed_precision():
                loss = _error(network, data, rows, middle, spread)
            optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(network.parameters(), LONGEST_STEP)
            optimizer.step()
            schedule.step()
            losses.append(loss.detach())
        error = _validate(network, held_out, middle, spread) * spread**2
        state.add(float(torch.stack(losses).mean()), error)
        progress(len(state.curve) / config.epochs)
    state.restore()
    return export_weights(network, centre, spread)


def pad_sequences(
    config: Config, examples: Examples, clusters: NDArray[np.int8]
) -> tuple[Floats, Floats, Floats]:
    """Utterances of one length: inputs, targets (n, frames, features or modes), weights (n, frames).

    A shorter utterance is padded with its last phone, with weight 0.
    """
    longest, modes = max(len(times) for times in examples.times), examples.targets[0].shape[1]
    signals = np.empty((len(examples), longest, n_columns(config)), np.float32)
    targets = np.zeros((len(examples), longest, modes), np.float32)
    weights = np.zeros((len(examples), longest), np.float32)
    rows = zip(
        examples.tracks, examples.times, examples.targets, examples.weights, styles_of(examples), strict=True
    )
    for row, (track, times, target, weight, style) in enumerate(rows):
        signal = add_style(sequence_features(config.features, track, times, clusters), style, config.styles)
        signals[row, : len(times)], signals[row, len(times) :] = signal, signal[-1]
        targets[row, : len(times)], weights[row, : len(times)] = target, weight
    return signals, targets, weights


def _error(network: Network, data: list[Tensor], rows: Tensor, middle: Tensor, spread: float) -> Tensor:
    signals, targets, weights = (part[rows] for part in data)
    squared = ((network(signals) - (targets - middle) / spread) ** 2).mean(dim=2)
    return (squared * weights).sum() / weights.sum()


def _validate(network: Network, data: list[Tensor], middle: Tensor, spread: float) -> float:
    if not data:
        return 0.0
    network.eval()
    with torch.no_grad():
        return float(_error(network, data, torch.arange(len(data[0]), device=data[0].device), middle, spread))


def export_weights(network: Network, centre: NDArray[np.floating], spread: float) -> dict[str, Floats]:
    """A network's weights as `layer_shapes` of regressors/lstm.py names them; targets unscaled again."""
    found = {
        "input": network.input.weight.T,
        "input_bias": network.input.bias,
        "output": network.output.weight.T * spread,
        "output_bias": network.output.bias * spread + tensor(np.asarray(centre, np.float32)),
    }
    for number, layer in enumerate(network.recurrent):
        named = dict(layer.named_parameters())
        ends = ("", "_reverse") if "weight_ih_l0_reverse" in named else ("",)
        found[f"forward{number}"] = torch.stack([named[f"weight_ih_l0{e}"].T for e in ends])
        found[f"recur{number}"] = torch.stack([named[f"weight_hh_l0{e}"].T for e in ends])
        found[f"bias{number}"] = torch.stack(
            [named[f"bias_ih_l0{e}"] + named[f"bias_hh_l0{e}"] for e in ends]
        )
    return {name: np.ascontiguousarray(array(t), np.float32) for name, t in found.items()}
