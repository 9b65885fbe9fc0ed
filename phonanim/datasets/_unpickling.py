"""What a pickle of arrays may build: numbers, texts, containers and arrays, by checked constructors.

No NumPy object takes its state from the file; only objects of this module have one. Keys of dicts are texts
and numbers that cannot all have one hash. Bytes count as often as the file makes them, however short it is.
"""

from __future__ import annotations

import math
import pickle
import re
from collections.abc import Iterable
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

PLAIN_DTYPE = re.compile(r"[<>|=]?([biufc]\d{1,2}|S\d{1,9}|U\d{1,9})")
LARGEST_KEY = 1 << 60  # larger whole numbers may all have one hash, and a dict of them takes very long
MOST_MADE = 4  # bytes of arrays for each byte of the file


class PendingType:
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


class PendingArray:
    """An array that is not filled yet."""

    value: NDArray[Any] | None = None

    def __setstate__(self, state: Any) -> None:
        _, shape, kind, fortran, content = state
        self.value = _array(content, kind, shape, "F" if fortran else "C")


class ArrayClass:
    """Replaces numpy.ndarray, which a pickle may name but not call."""

    def __new__(cls, *arguments: Any) -> ArrayClass:
        raise pickle.UnpicklingError("it tries to call numpy.ndarray")


def _array(content: Any, kind: Any, shape: Any, order: Any = "C") -> NDArray[Any]:
    """A copy of bytes as an array, after checking their number against the shape."""
    if isinstance(content, str):
        content = content.encode("latin1")
    if not (
        isinstance(kind, PendingType) and isinstance(content, bytes | bytearray) and isinstance(shape, tuple)
    ):
        raise pickle.UnpicklingError("it has an array that is not of plain numbers")
    counts = [int(count) for count in shape]
    if min(counts, default=0) < 0 or math.prod(counts) * kind.dtype.itemsize != len(content):
        raise pickle.UnpicklingError(f"it has {len(content)} bytes for an array of shape {shape}")
    if kind.dtype.itemsize == 0:
        return np.zeros(counts, kind.dtype)
    return (
        np.frombuffer(bytes(content), kind.dtype).reshape(counts, order="F" if order == "F" else "C").copy()
    )


def _reconstruct(subtype: Any, shape: Any, code: Any) -> PendingArray:
    if subtype is not ArrayClass:
        raise pickle.UnpicklingError("it has an array of an unknown class")
    return PendingArray()


def _scalar(kind: Any, content: Any = b"") -> Any:
    return _array(content, kind, ())[()]


def _encode(text: Any, encoding: Any = "latin1") -> bytes:
    if not isinstance(text, str) or encoding not in ("latin1", "latin-1"):
        raise pickle.UnpicklingError(f"it tries to encode as {encoding!r}")
    return text.encode("latin1")


def _no_bytes() -> bytes:
    """Called by protocols 0 to 2 for empty bytes."""
    return b""


def _dict(pairs: Iterable[tuple[Any, Any]] = ()) -> dict[Any, Any]:
    return {_key(key): value for key, value in pairs}


def _key(key: Any) -> Any:
    """A key of a dict. Raises UnpicklingError for one of another kind than a text or a number."""
    number = isinstance(key, int | np.integer) and -LARGEST_KEY < key < LARGEST_KEY
    if not (number or isinstance(key, str | bytes)):
        raise pickle.UnpicklingError(f"it has a dict with a key of {type(key).__name__}")
    return key


CONSTRUCTORS = {
    ("__builtin__", "bytes"): _no_bytes,
    ("_codecs", "encode"): _encode,
    ("collections", "OrderedDict"): _dict,
    ("numpy", "dtype"): PendingType,
    ("numpy", "ndarray"): ArrayClass,
    ("numpy.core.multiarray", "_reconstruct"): _reconstruct,
    ("numpy.core.multiarray", "scalar"): _scalar,
    ("numpy.core.numeric", "_frombuffer"): _array,
}


REFUSED = (
    *("PERSID", "BINPERSID", "EXT1", "EXT2", "EXT4", "INST", "OBJ", "NEWOBJ_EX"),
    *("EMPTY_SET", "ADDITEMS", "FROZENSET", "NEXT_BUFFER", "READONLY_BUFFER"),
)
"""The operations that no pickle of arrays needs."""


def _refuse(unpickler: Any) -> None:
    raise pickle.UnpicklingError("it does something that a pickle of arrays does not need")


Python: Any = pickle._Unpickler  # the one in C cannot be told what to refuse


class ArrayUnpickler(Python):  # type: ignore[misc]
    """Unpickles numbers, texts, containers and arrays only."""

    def __init__(self, stream: BinaryIO, size: int) -> None:
        super().__init__(stream, encoding="latin1")
        self.room = MOST_MADE * size + (1 << 20)

    def reduce(self) -> None:
        """Call a constructor."""
        Python.load_reduce(self)
        self.count(self.stack[-1])

    def build(self) -> None:
        """Give an array, a dtype or a scaler its state."""
        state, made = self.stack.pop(), self.stack[-1]
        if not isinstance(made, PendingType | PendingArray | ScalerState):
            raise pickle.UnpicklingError("it gives a state to something that has none")
        made.__setstate__(state)
        self.count(getattr(made, "value", None))

    def count(self, made: Any) -> None:
        """Raise UnpicklingError when all that was made is much larger than the file."""
        self.room -= len(made) if isinstance(made, bytes) else getattr(made, "nbytes", 0)
        if self.room < 0:
            raise pickle.UnpicklingError("it makes much more than it holds")

    def set_item(self) -> None:
        """Put a pair into a dict."""
        value, key = self.stack.pop(), self.stack.pop()
        self.put(self.stack[-1], [key, value])

    def set_items(self) -> None:
        """Put pairs into a dict."""
        pairs = self.pop_mark()
        self.put(self.stack[-1], pairs)

    def new_dict(self) -> None:
        """A dict of pairs."""
        pairs = self.pop_mark()
        self.append({})
        self.put(self.stack[-1], pairs)

    def put(self, target: Any, pairs: list[Any]) -> None:
        """Put keys and values, one after the other, into a dict."""
        if type(target) is not dict:
            raise pickle.UnpicklingError("it puts pairs into something that is not a dict")
        target.update(zip(map(_key, pairs[::2]), pairs[1::2], strict=True))

    dispatch = {  # noqa: RUF012  the base class has it so
        **Python.dispatch,
        **dict.fromkeys((getattr(pickle, name)[0] for name in REFUSED), _refuse),
        pickle.REDUCE[0]: reduce,
        pickle.BUILD[0]: build,
        pickle.SETITEM[0]: set_item,
        pickle.SETITEMS[0]: set_items,
        pickle.DICT[0]: new_dict,
    }

    def find_class(self, module: str, name: str) -> Any:
        """The constructor of this module for a name. Raises UnpicklingError for every other name."""
        public = module.replace("numpy._core", "numpy.core")
        if (public, name) not in CONSTRUCTORS:
            raise pickle.UnpicklingError(f"it tries to run {module}.{name}")
        return CONSTRUCTORS[public, name]


class ScalerState:
    """A scaler's attributes, of which the names in `needs` are used; nothing of it is run."""

    needs: tuple[str, ...] = ()
    state: dict[str, Any]

    def __setstate__(self, state: Any) -> None:
        if not isinstance(state, dict):
            raise pickle.UnpicklingError("its scaler has no attributes")
        self.state = state


class _MinMax(ScalerState):
    """Scaled values are value times scale_ plus min_."""

    needs = ("min_",)


class _Standard(ScalerState):
    """Scaled values are value less mean_, over scale_."""

    needs = ("mean_",)


SCALERS = {"MinMaxScaler": _MinMax, "StandardScaler": _Standard}


class ScalerUnpickler(ArrayUnpickler):
    """Unpickles scalers of scikit-learn, too, as their attributes."""

    def find_class(self, module: str, name: str) -> Any:
        """The constructor of this module for a name. Raises UnpicklingError for every other name."""
        if module in ("sklearn.preprocessing._data", "sklearn.preprocessing.data") and name in SCALERS:
            return SCALERS[name]
        return super().find_class(module, name)
