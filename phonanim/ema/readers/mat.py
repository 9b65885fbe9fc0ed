"""MATLAB files of named signals, the articulography format of Haskins Laboratories and others."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from phonanim.core.mat import DAMAGE, read_signals
from phonanim.ema.articulation import Articulation
from phonanim.errors import CorpusError

AXES = 3


def recognizes(path: Path) -> bool:
    """Whether the file has the suffix of MATLAB files."""
    return path.suffix.lower() == ".mat"


def read(path: Path) -> Articulation:
    """Elements of a structure array (NAME, SRATE, SIGNAL) whose signals have three or more columns, x y z mm.

    Raises CorpusError when there are none or their rates differ, MissingExtraError without SciPy.
    """
    signals = read_signals(path)
    try:
        arrays = {name: np.asarray(signal["SIGNAL"]) for name, signal in signals.items()}
        sensors = {name: a for name, a in arrays.items() if a.ndim == 2 and a.shape[1] >= AXES}
        (rate,) = {float(signals[name]["SRATE"]) for name in sensors}
        positions = np.stack([a[:, :AXES].astype(np.float64) for a in sensors.values()], axis=1)
    except DAMAGE as error:
        raise CorpusError(f"{path}: has no sensors with SRATE and SIGNAL of one rate ({error!r})") from error
    return Articulation(tuple(sensors), positions, rate, source=str(path))
