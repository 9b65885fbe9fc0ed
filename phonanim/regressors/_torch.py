"""Gradient descent for the regressors that need it; imported by `fit` alone, never to animate."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError
from phonanim.regressors import Examples, Progress
from phonanim.speech.gestures import GESTURES

try:
    import torch
    from torch import Tensor, nn
except ImportError as error:
    raise MissingExtraError(
        "training needs PyTorch; install it with pip install 'phonanim[train]'"
    ) from error

if TYPE_CHECKING:
    from phonanim.regressors.dnn import Config as NetworkConfig
    from phonanim.regressors.procedural import Config as DominanceConfig

Layers = list[tuple[NDArray[np.float32], NDArray[np.float32]]]
ACTIVATIONS = {"tanh": nn.Tanh, "silu": nn.SiLU}


@dataclass(frozen=True)
class Rows:
    """Training rows: inputs (rows, features), targets (rows, width * modes), weights (rows,)."""

    inputs: NDArray[np.float32]
    targets: NDArray[np.float32]
    weights: NDArray[np.float32]


def seeded(rng: np.random.Generator) -> torch.Generator:
    """A torch generator that follows the numpy one; also seeds torch's own, which initializes layers."""
    seed = int(rng.integers(2**31))
    torch.manual_seed(seed)
    return torch.Generator().manual_seed(seed)


def fit_network(
    config: NetworkConfig, train: Rows, held_out: Rows, rng: np.random.Generator, progress: Progress
) -> Layers:
    """Train a fully connected network; returns (weights (in, out), bias (out,)) of each layer.

    Inputs are standardized and targets scaled for training; both are folded into the first and last
    layers. The state with the least validation error is kept; training ends when `patience` epochs
    brought none better.
    """
    generator = seeded(rng)
    mean, scale = train.inputs.mean(axis=0), train.inputs.std(axis=0) + 1e-3
    if not config.standardize:
        mean, scale = np.zeros_like(mean), np.ones_like(scale)
    centre, spread = train.targets.mean(axis=0), float(train.targets.std())
    network = _network(config, train.inputs.shape[1], train.targets.shape[1])
    optimizer = _optimizer(config, network)
    batches = -(-len(train.inputs) // config.batch)
    schedule = None
    if config.optimizer == "adamw":
        schedule = torch.optim.lr_scheduler.OneCycleLR(
            optimizer, config.rate, total_steps=config.epochs * batches, pct_start=0.1
        )
    data = [torch.from_numpy(a) for a in (train.inputs, train.targets, train.weights)]
    shift, stretch = torch.from_numpy(mean), torch.from_numpy(scale)
    middle = torch.from_numpy(centre)
    best, best_state, waited = np.inf, copy.deepcopy(network.state_dict()), 0
    for epoch in range(config.epochs):
        network.train()
        for rows in torch.split(torch.randperm(len(data[0]), generator=generator), config.batch):
            predicted = network((data[0][rows] - shift) / stretch)
            squared = ((predicted - (data[1][rows] - middle) / spread) ** 2).mean(dim=1)
            loss = (squared * data[2][rows]).mean()
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            if schedule:
                schedule.step()
        error = _error(network, held_out, shift, stretch, middle, spread)
        if error < best:
            best, best_state, waited = error, copy.deepcopy(network.state_dict()), 0
        else:
            waited += 1
        progress((epoch + 1) / config.epochs)
        if waited > config.patience:
            break
    network.load_state_dict(best_state)
    layers = [m for m in network if isinstance(m, nn.Linear)]
    found = [(m.weight.detach().numpy().T.copy(), m.bias.detach().numpy().copy()) for m in layers]
    return _folded(found, mean, scale, centre, spread)


def _network(config: NetworkConfig, n_inputs: int, n_outputs: int) -> nn.Sequential:
    layers: list[nn.Module] = []
    for size in config.hidden:
        layers += [nn.Linear(n_inputs, size), ACTIVATIONS[config.activation](), nn.Dropout(config.dropout)]
        n_inputs = size
    return nn.Sequential(*layers, nn.Linear(n_inputs, n_outputs))


def _optimizer(config: NetworkConfig, network: nn.Module) -> torch.optim.Optimizer:
    if config.optimizer == "sgd":
        return torch.optim.SGD(network.parameters(), lr=config.rate, momentum=config.momentum)
    return torch.optim.AdamW(network.parameters(), lr=config.rate, weight_decay=config.decay)


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
            predicted = network((torch.from_numpy(rows.inputs[part]) - shift) / stretch) * spread + middle
            total += float(((predicted - torch.from_numpy(rows.targets[part])) ** 2).sum())
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


class _Dominance(nn.Module):
    """The tables of regressors/procedural.py while they are fitted: shared by articulation, plus own."""

    def __init__(self, modes: int) -> None:
        super().__init__()
        gestures = np.column_stack([GESTURES.articulation, np.ones(len(GESTURES.names), np.float32)])
        self.articulation = torch.from_numpy(gestures.astype(np.float32))
        columns, count = gestures.shape[1], len(gestures)
        self.shared = nn.ParameterList([torch.zeros(columns, modes) for _ in range(4)])
        self.own = nn.ParameterList([torch.zeros(count, modes) for _ in range(4)])
        self.exponent = nn.Parameter(torch.zeros(modes))
        self.rest = nn.Parameter(torch.zeros(modes))
        self.core = nn.Parameter(torch.tensor(0.0))

    def tables(self) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        raw = [self.articulation @ s + o for s, o in zip(self.shared, self.own, strict=True)]
        # 50 ms times about 1.3 where nothing is known yet: the usual reach of coarticulation.
        constants = [nn.functional.softplus(r + 1) * 0.05 for r in raw[2:]]
        return raw[0], raw[1], constants[0], constants[1]

    def forward(self, gesture: Tensor, begin: Tensor, end: Tensor, exists: Tensor) -> Tensor:
        from phonanim.regressors.procedural import LONG, SHORT

        target, strength, onset, offset = self.tables()
        middle, half = (begin + end) / 2, (end - begin) / 2 * torch.sigmoid(self.core)
        away = torch.relu(middle - half)[..., None] / onset[gesture]
        away = away + torch.relu(-(middle + half))[..., None] / offset[gesture]
        pull = strength[gesture] - (away + 1e-4) ** (1 + torch.sigmoid(self.exponent))
        pull = pull + torch.log(torch.clamp(end - begin, SHORT, LONG))[..., None] / 2
        weight = torch.softmax(pull.masked_fill(~exists[..., None], -1e9), dim=1)
        return (weight * target[gesture]).sum(dim=1) + self.rest


def fit_dominance(
    config: DominanceConfig, train: Examples, rng: np.random.Generator, progress: Progress
) -> dict[str, Any]:
    """Fit dominance functions to examples; returns the fields of `Procedural`."""
    from phonanim.regressors.procedural import TABLES, neighbours

    generator = seeded(rng)
    near = [neighbours(track, times) for track, times in zip(train.tracks, train.times, strict=True)]
    data = [
        torch.from_numpy(np.concatenate([getattr(n, name) for n in near]))
        for name in ("gesture", "begin", "end", "exists")
    ]
    targets = np.concatenate(train.targets)
    spread = float(targets.std())
    wanted = torch.from_numpy(targets / spread)
    model = _Dominance(targets.shape[1])
    optimizer = torch.optim.Adam(model.parameters(), lr=config.rate)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, config.rate, total_steps=config.steps)
    for step in range(config.steps):
        rows = torch.randint(len(wanted), (config.batch,), generator=generator)
        loss = ((model(*[part[rows] for part in data]) - wanted[rows]) ** 2).sum(dim=1).mean()
        loss = loss + 0.05 * config.own * sum((p**2).sum() for p in model.own)
        loss = loss + 0.05 * config.shared * sum((p**2).sum() for p in model.shared)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
        progress((step + 1) / config.steps)
    with torch.no_grad():
        found = dict(zip(TABLES, (table.numpy() for table in model.tables()), strict=True))
        found["exponent"] = (1 + torch.sigmoid(model.exponent)).numpy()
        found["rest"] = model.rest.numpy() * spread
        found["core"] = torch.sigmoid(model.core).reshape(1).numpy()
    found["target"] = found["target"] * spread
    return {name: np.asarray(table, np.float32) for name, table in found.items()}
