"""Gradient descent for regressors/procedural.py; imported by its `fit` only."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from phonanim.regressors import Examples, Progress
from phonanim.regressors._procedural_config import LONG, SHORT, TABLES, Config, neighbours
from phonanim.regressors._torch import array, device, tensor
from phonanim.regressors._torch_journal import State, state_key
from phonanim.speech.gestures import GESTURES

EPOCH = 50  # steps, after which the state is saved


class _Dominance(nn.Module):
    """The tables of regressors/procedural.py during the fit: shared by articulation, plus individual ones."""

    def __init__(self, modes: int) -> None:
        super().__init__()
        gestures = np.column_stack([GESTURES.articulation, np.ones(len(GESTURES.names), np.float32)])
        self.articulation = tensor(gestures.astype(np.float32))
        columns, count = gestures.shape[1], len(gestures)
        self.shared = nn.ParameterList([torch.zeros(columns, modes) for _ in range(4)])
        self.own = nn.ParameterList([torch.zeros(count, modes) for _ in range(4)])
        self.exponent = nn.Parameter(torch.zeros(modes))
        self.rest = nn.Parameter(torch.zeros(modes))
        self.core = nn.Parameter(torch.tensor(0.0))

    def tables(self) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        raw = [self.articulation @ s + o for s, o in zip(self.shared, self.own, strict=True)]
        # Initial value: 50 ms times about 1.3, the usual reach of coarticulation.
        constants = [nn.functional.softplus(r + 1) * 0.05 for r in raw[2:]]
        return raw[0], raw[1], constants[0], constants[1]

    def forward(self, gesture: Tensor, begin: Tensor, end: Tensor, exists: Tensor) -> Tensor:
        target, strength, onset, offset = self.tables()
        middle, half = (begin + end) / 2, (end - begin) / 2 * torch.sigmoid(self.core)
        away = torch.relu(middle - half)[..., None] / onset[gesture]
        away = away + torch.relu(-(middle + half))[..., None] / offset[gesture]
        pull = strength[gesture] - (away + 1e-4) ** (1 + torch.sigmoid(self.exponent))
        pull = pull + torch.log(torch.clamp(end - begin, SHORT, LONG))[..., None] / 2
        weight = torch.softmax(pull.masked_fill(~exists[..., None], -1e9), dim=1)
        return (weight * target[gesture]).sum(dim=1) + self.rest


def fit_dominance(
    config: Config,
    train: Examples,
    generator: torch.Generator,
    progress: Progress,
    journal: Path | None = None,
) -> dict[str, Any]:
    """Fit dominance functions to examples; returns the fields of `Procedural`.

    An interrupted training is continued from `journal`.
    """
    near = [neighbours(track, times) for track, times in zip(train.tracks, train.times, strict=True)]
    inputs = [
        np.concatenate([getattr(n, name) for n in near]) for name in ("gesture", "begin", "end", "exists")
    ]
    targets = np.concatenate(train.targets)
    spread = float(targets.std())
    data, wanted = [tensor(part) for part in inputs], tensor(targets / spread)
    model = _Dominance(targets.shape[1]).to(device())
    optimizer = torch.optim.Adam(model.parameters(), lr=config.rate)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, config.rate, total_steps=config.steps)
    key = state_key(config, generator.initial_seed(), (*inputs, targets) if journal else ())
    state = State(model, optimizer, [], [], key, journal, schedule, generator)
    state.resume()
    for first in range(len(state.curve) * EPOCH, config.steps, EPOCH):
        losses = []
        for step in range(first, min(first + EPOCH, config.steps)):
            rows = torch.randint(len(wanted), (config.batch,), generator=generator)
            loss = ((model(*[part[rows] for part in data]) - wanted[rows]) ** 2).sum(dim=1).mean()
            loss = loss + 0.05 * config.own * sum((p**2).sum() for p in model.own)
            loss = loss + 0.05 * config.shared * sum((p**2).sum() for p in model.shared)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            losses.append(loss.detach())
            progress((step + 1) / config.steps)
        state.add(float(torch.stack(losses).mean()), 0.0)
    return export_tables(model, spread)


def export_tables(model: _Dominance, spread: float) -> dict[str, Any]:
    """The fields of `Procedural`, with targets unscaled again."""
    with torch.no_grad():
        found = dict(zip(TABLES, (array(table) for table in model.tables()), strict=True))
        found["exponent"] = array(1 + torch.sigmoid(model.exponent))
        found["rest"] = array(model.rest) * spread
        found["core"] = array(torch.sigmoid(model.core).reshape(1))
    found["target"] = found["target"] * spread
    return {name: np.asarray(table, np.float32) for name, table in found.items()}
