"""Gradient descent for regressors/dnn.py; imported by its `fit` only."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from phonanim.regressors import Progress
from phonanim.regressors._dnn_config import Config
from phonanim.regressors._torch import array, device, mixed_precision, tensor
from phonanim.regressors._torch_journal import State, state_key

Layers = list[tuple[NDArray[np.float32], NDArray[np.float32]]]
ACTIVATIONS = {"tanh": nn.Tanh, "silu": nn.SiLU}


@dataclass(frozen=True)
class Rows:
    """Training rows: inputs (rows, features), targets (rows, width * modes), weights (rows,)."""

    inputs: NDArray[np.float32]
    targets: NDArray[np.float32]
    weights: NDArray[np.float32]


def fit_network(
    config: Config,
    train: Rows,
    held_out: Rows,
    generator: torch.Generator,
    progress: Progress,
    journal: Path | None = None,
) -> Layers:
    """Train a fully connected network; returns (weights (in, out), bias (out,)) of each layer.

    Inputs are standardized and targets scaled for training; both are folded into the first and last layers.
    The state with the least validation error is kept, or the last without rows to validate on; training ends
    after `patience` epochs without improvement. An interrupted training is continued from `journal`.
    """
    mean, scale = train.inputs.mean(axis=0), train.inputs.std(axis=0) + 1e-3
    if not config.standardize:
        mean, scale = np.zeros_like(mean), np.ones_like(scale)
    centre, spread = train.targets.mean(axis=0), float(train.targets.std())
    network = _network(config, train.inputs.shape[1], train.targets.shape[1]).to(device())
    optimizer = _optimizer(config, network)
    schedule = _schedule(config, optimizer, max(1, config.epochs * -(-len(train.inputs) // config.batch)))
    data = [tensor(a) for a in (train.inputs, train.targets, train.weights)]
    shift, stretch = tensor(mean), tensor(scale)
    middle = tensor(centre)
    blocks = (train.inputs, train.targets) if journal else ()
    key = state_key(config, generator.initial_seed(), blocks)
    state = State(network, optimizer, [], [], key, journal, schedule, generator, keep_first=True)
    state.resume()
    while not state.ended(config):
        network.train()
        losses = []
        for rows in torch.split(torch.randperm(len(data[0]), generator=generator), config.batch):
            with mixed_precision():
                predicted = network((data[0][rows] - shift) / stretch).float()
            squared = ((predicted - (data[1][rows] - middle) / spread) ** 2).mean(dim=1)
            loss = (squared * data[2][rows]).mean()
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            if schedule:
                schedule.step()
            losses.append(loss.detach())
        error = _error(network, held_out, shift, stretch, middle, spread)
        state.add(float(torch.stack(losses).mean()), error)
        progress(len(state.curve) / config.epochs)
    state.restore()
    layers = [m for m in network if isinstance(m, nn.Linear)]
    found = [(array(m.weight).T.copy(), array(m.bias).copy()) for m in layers]
    return _folded(found, mean, scale, centre, spread)


def _network(config: Config, n_inputs: int, n_outputs: int) -> nn.Sequential:
    layers: list[nn.Module] = []
    for size in config.hidden:
        layers += [nn.Linear(n_inputs, size), ACTIVATIONS[config.activation](), nn.Dropout(config.dropout)]
        n_inputs = size
    return nn.Sequential(*layers, nn.Linear(n_inputs, n_outputs))


def _optimizer(config: Config, network: nn.Module) -> torch.optim.Optimizer:
    if config.optimizer == "sgd":
        return torch.optim.SGD(network.parameters(), lr=config.rate, momentum=config.momentum)
    return torch.optim.AdamW(network.parameters(), lr=config.rate, weight_decay=config.decay)


def _schedule(
    config: Config, optimizer: torch.optim.Optimizer, steps: int
) -> torch.optim.lr_scheduler.LRScheduler | None:
    """What changes the rate over a number of steps; None where it stays."""
    kind = config.schedule or ("cycle" if config.optimizer == "adamw" else "constant")
    if kind == "cycle":
        adaptive = config.optimizer == "adamw"  # SGD keeps the momentum that it was given
        return torch.optim.lr_scheduler.OneCycleLR(
            optimizer, config.rate, total_steps=steps, pct_start=0.1, cycle_momentum=adaptive
        )
    if kind == "cosine":
        return torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
    return None


def _error(
    network: nn.Module, rows: Rows, shift: Tensor, stretch: Tensor, middle: Tensor, spread: float
) -> float:
    if len(rows.inputs) == 0:
        return 0.0
    network.eval()
    total = 0.0
    with torch.no_grad():
        for begin in range(0, len(rows.inputs), 8192):
            part = slice(begin, begin + 8192)
            predicted = network((tensor(rows.inputs[part]) - shift) / stretch) * spread + middle
            total += float(((predicted - tensor(rows.targets[part])) ** 2).sum())
    return total / rows.targets.size


def _folded(
    layers: Layers,
    mean: NDArray[np.float32],
    scale: NDArray[np.float32],
    centre: NDArray[np.float32],
    spread: float,
) -> Layers:
    weights, bias = layers[0]
    layers[0] = (weights / scale[:, None], bias - np.asarray((mean / scale) @ weights, np.float32))
    weights, bias = layers[-1]
    layers[-1] = (weights * np.float32(spread), bias * np.float32(spread) + centre)
    return [(w.astype(np.float32), b.astype(np.float32)) for w, b in layers]
