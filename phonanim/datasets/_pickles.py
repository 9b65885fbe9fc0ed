"""Pickles of arrays, read without running what else a pickle may hold."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

from phonanim.errors import CorpusError

ALLOWED = {
    ("_codecs", "encode"),
    ("collections", "OrderedDict"),
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    ("numpy.core.multiarray", "_reconstruct"),
    ("numpy.core.multiarray", "scalar"),
    ("numpy.core.numeric", "_frombuffer"),
}


class _Arrays(pickle.Unpickler):
    """Knows numbers, texts, containers and arrays."""

    def find_class(self, module: str, name: str) -> Any:
        """The class or function, where it is one that makes an array."""
        public = module.replace("numpy._core", "numpy.core")
        if (public, name) not in ALLOWED:
            raise pickle.UnpicklingError(f"it wants to run {module}.{name}")
        try:  # NumPy 2 has the underscore, NumPy 1 has not
            return super().find_class(public.replace("numpy.core", "numpy._core"), name)
        except ModuleNotFoundError:
            return super().find_class(public, name)


def read_pickle(path: Path) -> Any:
    """The content of a pickle of Python 2 or 3. Raises CorpusError when it is damaged or not of arrays."""
    try:
        with path.open("rb") as stream:
            return _Arrays(stream, encoding="latin1").load()
    except (
        OSError,
        pickle.UnpicklingError,
        EOFError,
        AttributeError,
        ValueError,
        IndexError,
        KeyError,
    ) as error:
        raise CorpusError(f"{path}: cannot be read as a pickle of arrays: {error}") from error
