"""Read pickles of arrays without calling anything that a pickle names.

A pickle is a program. Here it can only build numbers, texts, lists, dicts and arrays of plain numbers: each
name that real files use is mapped to a checked constructor of `phonanim.datasets._unpickling`.
"""

from __future__ import annotations

import pickle
import pickletools
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import fault_reason
from phonanim.core.files import open_plain
from phonanim.datasets._unpickling import (
    ArrayClass,
    ArrayUnpickler,
    PendingArray,
    PendingType,
    ScalerUnpickler,
)
from phonanim.errors import CorpusError

MOST_STEPS = 4_000_000  # operations in one file; the largest known file has a tenth of this
DEEPEST = 50  # containers within containers
FAULTS = (
    OSError,
    pickle.UnpicklingError,
    EOFError,
    struct.error,
    AttributeError,
    ImportError,
    TypeError,
    ValueError,
    IndexError,
    KeyError,
    OverflowError,
    MemoryError,
    RecursionError,
)


def read_pickle(path: Path) -> Any:
    """The content of a pickle of Python 2 or 3. Raises CorpusError when it is damaged or not of arrays."""
    try:
        with open_plain(path) as stream:
            _check_steps(stream, path.stat().st_size)
            stream.seek(0)
            return _finished(ArrayUnpickler(stream, path.stat().st_size).load())
    except FAULTS as error:
        raise CorpusError(f"{path}: cannot be read as a pickle of arrays: {fault_reason(error)}") from error


@dataclass(frozen=True)
class Scaler:
    """The inverse of a scaling: value times `factor` plus `offset`, (values,) each."""

    factor: NDArray[np.float64]
    offset: NDArray[np.float64]


def read_scaler(path: Path) -> Scaler:
    """The inverse of scikit-learn's MinMaxScaler or StandardScaler in a pickle. Raises CorpusError."""
    try:
        with open_plain(path) as stream:
            _check_steps(stream, path.stat().st_size)
            stream.seek(0)
            found = ScalerUnpickler(stream, path.stat().st_size).load()
        state = {name: _finished(found.state[name]) for name in (*found.needs, "scale_")}
        scale, shift = (np.asarray(state[name], np.float64) for name in ("scale_", found.needs[0]))
        if scale.ndim != 1 or scale.shape != shift.shape or not scale.all() or not np.isfinite(scale).all():
            raise ValueError("its scale is not one number for each value")
    except (*FAULTS, AttributeError) as error:
        why = fault_reason(error)
        raise CorpusError(f"{path}: cannot be read as a scaler of scikit-learn: {why}") from error
    return Scaler(1 / scale, -shift / scale) if found.needs == ("min_",) else Scaler(scale, shift)


def _check_steps(stream: BinaryIO, size: int) -> None:
    """Raise ValueError for too many steps, or for a step that needs more memory than the file has."""
    for number, (operation, argument, _) in enumerate(pickletools.genops(stream)):
        if number > MOST_STEPS:
            raise ValueError(f"it has more than {MOST_STEPS:,} steps")
        if operation.name in ("LONG_BINPUT", "PUT") and int(argument or 0) > size:
            raise ValueError(f"it stores item {argument} of a file of {size} bytes")


def _finished(value: Any, depth: int = 0, done: dict[int, Any] | None = None) -> Any:
    """Containers with finished arrays in them. Raises UnpicklingError for an array that was never filled.

    A container that is referenced several times is finished once: `done` maps its identity to the result.
    """
    done = {} if done is None else done
    if depth > DEEPEST:
        raise pickle.UnpicklingError(f"it nests more than {DEEPEST} containers")
    if isinstance(value, PendingArray):
        if value.value is None:
            raise pickle.UnpicklingError("it has an array without content")
        return value.value
    if isinstance(value, dict | list | tuple):
        if id(value) not in done:
            pairs = value.items() if isinstance(value, dict) else enumerate(value)
            parts = {key: _finished(item, depth + 1, done) for key, item in pairs}
            done[id(value)] = parts if isinstance(value, dict) else type(value)(parts.values())
        return done[id(value)]
    if isinstance(value, PendingType | ArrayClass) or callable(value):
        raise pickle.UnpicklingError("it has something that is not a number, a text or an array")
    return value
