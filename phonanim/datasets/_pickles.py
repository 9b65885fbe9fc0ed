"""Read pickles of arrays without calling anything that a pickle names.

A pickle is a program. Here it can only build numbers, texts, lists, dicts and arrays of plain numbers: each
name that real files use is mapped to a checked constructor of this module, and no NumPy object takes its
state from the file.
"""

from __future__ import annotations

import math
import pickle
import pickletools
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import open_plain
from phonanim.errors import CorpusError

PLAIN_DTYPE = re.compile(r"[<>|=]?([biufc]\d{1,2}|S\d{1,9}|U\d{1,9})")
MOST_STEPS = 4_000_000  # operations in one file; the largest known file has a tenth of this
DEEPEST = 50  # containers within containers
FAULTS = (
    OSError,
    pickle.UnpicklingError,
    EOFError,
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
            return _finished(_Arrays(stream, encoding="latin1").load())
    except FAULTS as error:
        reason = str(error) or type(error).__name__
        raise CorpusError(f"{path}: cannot be read as a pickle of arrays: {reason}") from error


@dataclass(frozen=True)
class Scaler:
    """The inverse of a scaling: value times `factor` plus `offset`, (values,) each."""

    factor: NDArray[np.float64]
    offset: NDArray[np.float64]


def read_scaler(path: Path) -> Scaler:
    """The inverse of scikit-learn's MinMaxScaler or StandardScaler in a pickle. Raises CorpusError."""
    try:
        with path.open("rb") as stream:
            _check_steps(stream, path.stat().st_size)
            stream.seek(0)
            found = _Scalers(stream, encoding="latin1").load()
        state = {name: _finished(found.state[name]) for name in (*found.needs, "scale_")}
        scale, shift = (np.asarray(state[name], np.float64) for name in ("scale_", found.needs[0]))
        if scale.ndim != 1 or scale.shape != shift.shape or not scale.all() or not np.isfinite(scale).all():
            raise ValueError("its scale is not one number for each value")
    except (*FAULTS, AttributeError) as error:
        reason = str(error) or type(error).__name__
        raise CorpusError(f"{path}: cannot be read as a scaler of scikit-learn: {reason}") from error
    return Scaler(1 / scale, -shift / scale) if found.needs == ("min_",) else Scaler(scale, shift)


def _check_steps(stream: BinaryIO, size: int) -> None:
    """Raise ValueError for too many steps, or for a step that needs more memory than the file has."""
    for number, (operation, argument, _) in enumerate(pickletools.genops(stream)):
        if number > MOST_STEPS:
            raise ValueError(f"it has more than {MOST_STEPS:,} steps")
        if operation.name in ("LONG_BINPUT", "PUT") and int(argument or 0) > size:
            raise ValueError(f"it stores item {argument} of a file of {size} bytes")


class _Type:
    """A dtype whose byte order is not set yet."""

    def __init__(self, name: Any, align: Any = False, copy: Any = False) -> None:
        if not isinstance(name, str) or not PLAIN_DTYPE.fullmatch(name):
            raise pickle.UnpicklingError(f"it has an array of {name!r}, which are not plain numbers")
        self.dtype = np.dtype(name)

    def __setstate__(self, state: Any) -> None:
        order = state[1]
        if order not in ("<", ">", "|", "="):
            raise pickle.UnpicklingError(f"its byte order is {order!r}")
        self.dtype = self.dtype.newbyteorder(order)


class _Array:
    """An array that is not filled yet."""

    value: NDArray[Any] | None = None

    def __setstate__(self, state: Any) -> None:
        _, shape, kind, fortran, content = state
        self.value = _array(content, kind, shape, "F" if fortran else "C")


class _Subtype:
    """Replaces numpy.ndarray, which a pickle may name but not call."""

    def __new__(cls, *arguments: Any) -> _Subtype:
        raise pickle.UnpicklingError("it tries to call numpy.ndarray")


def _array(content: Any, kind: Any, shape: Any, order: Any = "C") -> NDArray[Any]:
    """A copy of bytes as an array, after checking their number against the shape."""
    if isinstance(content, str):
        content = content.encode("latin1")
    if not (isinstance(kind, _Type) and isinstance(content, bytes | bytearray) and isinstance(shape, tuple)):
        raise pickle.UnpicklingError("it has an array that is not of plain numbers")
    counts = [int(count) for count in shape]
    if min(counts, default=0) < 0 or math.prod(counts) * kind.dtype.itemsize != len(content):
        raise pickle.UnpicklingError(f"it has {len(content)} bytes for an array of shape {shape}")
    if kind.dtype.itemsize == 0:
        return np.zeros(counts, kind.dtype)
    return (
        np.frombuffer(bytes(content), kind.dtype).reshape(counts, order="F" if order == "F" else "C").copy()
    )


def _reconstruct(subtype: Any, shape: Any, code: Any) -> _Array:
    if subtype is not _Subtype:
        raise pickle.UnpicklingError("it has an array of an unknown class")
    return _Array()


def _scalar(kind: Any, content: Any = b"") -> Any:
    return _array(content, kind, ())[()]


def _encode(text: Any, encoding: Any = "latin1") -> bytes:
    if not isinstance(text, str) or encoding not in ("latin1", "latin-1"):
        raise pickle.UnpicklingError(f"it tries to encode as {encoding!r}")
    return text.encode("latin1")


def _no_bytes() -> bytes:
    """Called by protocols 0 to 2 for empty bytes."""
    return b""


CONSTRUCTORS = {
    ("__builtin__", "bytes"): _no_bytes,
    ("_codecs", "encode"): _encode,
    ("collections", "OrderedDict"): dict,
    ("numpy", "dtype"): _Type,
    ("numpy", "ndarray"): _Subtype,
    ("numpy.core.multiarray", "_reconstruct"): _reconstruct,
    ("numpy.core.multiarray", "scalar"): _scalar,
    ("numpy.core.numeric", "_frombuffer"): _array,
}


class _Arrays(pickle.Unpickler):
    """Unpickles numbers, texts, containers and arrays only."""

    def find_class(self, module: str, name: str) -> Any:
        """The constructor of this module for a name. Raises UnpicklingError for every other name."""
        public = module.replace("numpy._core", "numpy.core")
        if (public, name) not in CONSTRUCTORS:
            raise pickle.UnpicklingError(f"it tries to run {module}.{name}")
        return CONSTRUCTORS[public, name]


class _ScalerState:
    """A scaler's attributes, of which the names in `needs` are used; nothing of it is run."""

    needs: tuple[str, ...] = ()
    state: dict[str, Any]

    def __setstate__(self, state: Any) -> None:
        if not isinstance(state, dict):
            raise pickle.UnpicklingError("its scaler has no attributes")
        self.state = state


class _MinMax(_ScalerState):
    """Scaled values are value times scale_ plus min_."""

    needs = ("min_",)


class _Standard(_ScalerState):
    """Scaled values are value less mean_, over scale_."""

    needs = ("mean_",)


SCALERS = {"MinMaxScaler": _MinMax, "StandardScaler": _Standard}


class _Scalers(_Arrays):
    """Unpickles scalers of scikit-learn, too, as their attributes."""

    def find_class(self, module: str, name: str) -> Any:
        """The constructor of this module for a name. Raises UnpicklingError for every other name."""
        if module in ("sklearn.preprocessing._data", "sklearn.preprocessing.data") and name in SCALERS:
            return SCALERS[name]
        return super().find_class(module, name)


def _finished(value: Any, depth: int = 0, done: dict[int, Any] | None = None) -> Any:
    """Containers with finished arrays in them. Raises UnpicklingError for an array that was never filled.

    A container that is referenced several times is finished once: `done` maps its identity to the result.
    """
    done = {} if done is None else done
    if depth > DEEPEST:
        raise pickle.UnpicklingError(f"it nests more than {DEEPEST} containers")
    if isinstance(value, _Array):
        if value.value is None:
            raise pickle.UnpicklingError("it has an array without content")
        return value.value
    if isinstance(value, dict | list | tuple):
        if id(value) not in done:
            pairs = value.items() if isinstance(value, dict) else enumerate(value)
            parts = {key: _finished(item, depth + 1, done) for key, item in pairs}
            done[id(value)] = parts if isinstance(value, dict) else type(value)(parts.values())
        return done[id(value)]
    if isinstance(value, _Type | _Subtype) or callable(value):
        raise pickle.UnpicklingError("it has something that is not a number, a text or an array")
    return value
