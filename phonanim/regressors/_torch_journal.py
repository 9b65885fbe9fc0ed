"""The progress of a training: the best epoch, early stopping, and the state that it is continued from."""

from __future__ import annotations

import csv
import hashlib
import io
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from phonanim.core.decode import DAMAGE, fault_reason
from phonanim.core.device import PRECISION
from phonanim.core.files import atomic_path, write_text
from phonanim.errors import ModelError
from phonanim.regressors import CHECKPOINT
from phonanim.regressors._torch import device

CURVE = "loss.csv"


def state_key(config: Any, seed: int, blocks: Iterable[NDArray[Any]]) -> str:
    """A hash of everything that a training depends on, so that no training continues another one's state.

    `blocks` are the numbers that it is trained on.
    """
    numbers = PRECISION.get().removeprefix("single")
    digest = hashlib.sha256(f"{config} {seed} {torch.__version__}{numbers}".encode())
    for block in blocks:
        digest.update(np.ascontiguousarray(block).tobytes())
    return digest.hexdigest()


@dataclass
class State:
    """The progress of a training: `curve` has (loss, validation error) of each epoch.

    Trainings without a seed for each epoch give the `generator` that they draw from, and their `schedule`. Of
    epochs with the same error the last is kept, or with `keep_first` the first.
    """

    network: nn.Module
    optimizer: Any
    curve: list[tuple[float, float]]
    best: list[Any]
    key: str
    journal: Path | None
    schedule: Any = None
    generator: torch.Generator | None = None
    keep_first: bool = False

    def ended(self, config: Any) -> bool:
        """Whether all epochs are done, or the last `patience` of them brought no improvement."""
        if not self.curve:
            return bool(config.epochs == 0)
        errors = [error for _, error in self.curve]
        waited = len(errors) - 1 - int(np.argmin(errors))
        return len(errors) >= config.epochs or (waited > config.patience and errors[-1] > 0)

    def add(self, mean_loss: float, error: float) -> None:
        """Record an epoch, keep the weights if they are the best, and write all of it to the journal."""
        before = min((known for _, known in self.curve), default=np.inf)
        self.curve.append((mean_loss, error))
        # Without clips to validate on, all errors are 0.
        if error < before or (error == before and not (self.keep_first and error > 0)):
            self.best = [part.detach().clone() for part in self.network.state_dict().values()]
        if self.journal:
            self._write(self.journal)

    def restore(self) -> None:
        """Go back to the best weights."""
        if self.best:
            names = self.network.state_dict()
            self.network.load_state_dict(dict(zip(names, self.best, strict=True)))

    def _write(self, journal: Path) -> None:
        journal.mkdir(parents=True, exist_ok=True)
        parts = {
            "key": self.key,
            "curve": self.curve,
            "best": self.best,
            "network": self.network.state_dict(),
            "optimizer": self.optimizer.state_dict(),
        }
        if self.schedule:
            parts["schedule"] = self.schedule.state_dict()
        if self.generator:
            parts["chance"] = (self.generator.get_state(), torch.get_rng_state())
        with atomic_path(journal / CHECKPOINT) as path:
            torch.save(parts, path)
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(("epoch", "training_loss", "validation_mm2"))
        rows.writerows((n + 1, f"{a:.6g}", f"{b:.6g}") for n, (a, b) in enumerate(self.curve))
        write_text(journal / CURVE, text.getvalue())

    def resume(self) -> None:
        """Continue from the journal, if it is of the same training. Raises ModelError when it is damaged."""
        if self.journal is None or not (self.journal / CHECKPOINT).is_file():
            return
        path = self.journal / CHECKPOINT
        try:
            parts = torch.load(path, weights_only=True, map_location=device())
            if parts["key"] == self.key:
                self._continue(parts)
        except (*DAMAGE, OSError, EOFError, RuntimeError, UnpicklingError) as error:
            reason = fault_reason(error)
            raise ModelError(
                f"{path}: is damaged ({reason}); delete it, and the training begins anew"
            ) from error

    def _continue(self, parts: dict[str, Any]) -> None:
        self.curve, self.best = [tuple(pair) for pair in parts["curve"]], parts["best"]
        self.network.load_state_dict(parts["network"])
        self.optimizer.load_state_dict(parts["optimizer"])
        if self.schedule:
            self.schedule.load_state_dict(parts["schedule"])
        if self.generator:
            own, default = (part.cpu() for part in parts["chance"])
            self.generator.set_state(own)
            torch.set_rng_state(default)
