"""Features on disk: one file for each recording and encoder, named by a hash of both."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError, map_array
from phonanim.core.files import atomic_path, concatenate_pieces
from phonanim.errors import OutputError
from phonanim.media.audio import Sound

FOLDER = "PHONANIM_CACHE"
Values = NDArray[np.float16]
LARGEST = float(np.finfo(np.float16).max)


def cache_folder() -> Path | None:
    """The cache folder: PHONANIM_CACHE, or the platform's cache folder; None when the variable is empty."""
    named = os.environ.get(FOLDER)
    if named is not None:
        return Path(named) if named else None
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData/Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library/Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "phonanim"


def cached_features(
    identity: str, sound: Sound, shape: tuple[int, int, int], pieces: Iterable[NDArray[np.float32]]
) -> Values:
    """Features from the cache; if they are not cached, `pieces` one after the other, which are then cached.

    Without a cache, long features are in a temporary file. Raises OutputError when there is no room.
    """
    folder = cache_folder()
    if folder is None:
        return concatenate_pieces(map(_half, pieces))
    path = folder / "features" / f"{fingerprint(identity, sound)}.npy"
    found = _read(path, shape)
    if found is None:
        _write(path, shape, pieces)
        found = map_array(path)
    return found


def fingerprint(identity: str, sound: Sound) -> str:
    """A hash of an encoder and a recording, 64 hex digits."""
    digest = hashlib.sha256(f"{identity}\n{sound.rate}\n".encode())
    digest.update(np.ascontiguousarray(sound.samples, "<f4").data)
    return digest.hexdigest()


def _read(path: Path, shape: tuple[int, int, int]) -> Values | None:
    """The content of a cache file; None when it is missing, damaged, or of another shape."""
    try:
        found: Values = map_array(path)
    except (OSError, DecodeError):
        return None
    return found if found.shape == shape and found.dtype == np.float16 else None


def _write(path: Path, shape: tuple[int, int, int], pieces: Iterable[NDArray[np.float32]]) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"{path.parent}: cannot be created ({error.strerror}); set {FOLDER} to a folder for the cache"
        ) from error
    with atomic_path(path) as partial:
        values = np.lib.format.open_memmap(partial, "w+", np.float16, shape)
        row = 0
        for piece in pieces:
            values[row : row + len(piece)] = _half(piece)
            row += len(piece)
        values.flush()
        del values  # a memory-mapped file cannot be renamed on every platform


def _half(piece: NDArray[np.float32]) -> Values:
    return np.clip(piece, -LARGEST, LARGEST).astype(np.float16)
