"""MATLAB files of named signals: a structure array with NAME, SRATE and SIGNAL."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from phonanim.errors import CorpusError, MissingExtraError

DAMAGE = (ValueError, KeyError, TypeError, IndexError, StopIteration)
"""The exceptions that a file of another structure raises."""


@lru_cache(maxsize=2)
def read_signals(path: Path) -> dict[str, Mapping[str, Any]]:
    """The elements of the structure array by their NAME. Raises CorpusError, MissingExtraError."""
    try:
        from scipy.io import loadmat
        from scipy.io.matlab import MatReadError
    except ImportError as error:
        raise MissingExtraError("MATLAB files need SciPy: pip install 'phonanim[train]'") from error
    try:
        document = loadmat(path, simplify_cells=True)
        elements = next(value for name, value in document.items() if not name.startswith("__"))
        return {str(element["NAME"]): element for element in elements}
    except (MatReadError, NotImplementedError, OSError, zlib.error, *DAMAGE) as error:
        raise CorpusError(f"{path}: is not a MATLAB file of named signals ({error!r})") from error
