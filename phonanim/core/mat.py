"""MATLAB files of named signals: a structure array with NAME, SRATE and SIGNAL."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from phonanim.core.decode import MAX_JSON, MAX_RATIO, MAX_UNPACKED
from phonanim.core.files import read_bounded
from phonanim.errors import CorpusError, MissingExtraError

HEADER = 128  # bytes of a file of MATLAB 5
PACKED = 15  # the type of an element that zlib packed
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
        data = read_bounded(path, MAX_JSON)
        _check_unpacked(data)
        document = loadmat(io.BytesIO(data), simplify_cells=True)
        elements = next(value for name, value in document.items() if not name.startswith("__"))
        return {str(element["NAME"]): element for element in elements}
    except (MatReadError, NotImplementedError, OSError, zlib.error, *DAMAGE) as error:
        raise CorpusError(f"{path}: is not a MATLAB file of named signals ({error!r})") from error


def _check_unpacked(data: bytes) -> None:
    """Raise ValueError for packed elements that become too large. SciPy refuses what is not MATLAB's."""
    order = ">" if data[126:128] == b"MI" else "<"
    at, room = HEADER, max(MAX_UNPACKED, MAX_RATIO * len(data))
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if kind == PACKED:
            unpacking = zlib.decompressobj()
            room -= len(unpacking.decompress(data[at + 8 : at + 8 + size], room + 1))
            if room < 0:
                raise ValueError("it unpacks to too much")
        at += 8 + size
