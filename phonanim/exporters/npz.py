"""NumPy archive: every curve at full precision, with its provenance."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.articulation import CHANNELS
from phonanim.core.decode import DAMAGE, parse_json, read_arrays
from phonanim.core.files import atomic_path
from phonanim.exporters._document import facts, from_values, not_ours

SUMMARY = "NumPy archive: `values` (frames, channels), `channels`, `fps`, phones, words, provenance"
EPOCH = (1980, 1, 1, 0, 0, 0)  # the same input gives the same bytes on any day


def write(animation: Animation, path: Path) -> None:
    """Write `values` (frames, channels) float32, `channels`, `fps`, `start`, `times`, and `about` as JSON.

    Where it is known, what the mouth does stands in `articulation` (frames, 10) float32 mm, under
    `articulation_channels`. Raises OutputError when the destination cannot be written.
    """
    arrays: dict[str, NDArray[Any] | np.generic] = {
        "values": np.asarray(animation.values, np.float32),
        "channels": np.array(animation.channels, dtype=np.str_),
        "fps": np.float64(animation.fps),
        "start": np.float64(animation.start),
        "times": animation.times,
        "about": np.array(json.dumps(facts(animation))),
    }
    if animation.articulation is not None:
        arrays["articulation"] = np.asarray(animation.articulation, np.float32)
        arrays["articulation_channels"] = np.array(CHANNELS, dtype=np.str_)
    save_arrays(path, arrays)


def read(path: Path) -> Animation:
    """Read an animation back. Raises OutputError when phonanim did not write the file."""
    try:
        arrays = read_arrays(path)
        about = parse_json(str(arrays["about"]))
        animation = from_values(about, arrays["values"], arrays["channels"].tolist(), path)
        return replace(animation, articulation=_articulation(arrays, len(animation.values)))
    except (OSError, *DAMAGE) as error:
        raise not_ours(path, error) from error


def _articulation(arrays: Mapping[str, NDArray[Any]], frames: int) -> NDArray[np.float32] | None:
    """What the mouth does, (frames, channels) mm, where it is known. Raises ValueError when damaged."""
    if "articulation" not in arrays:
        return None
    mouth = np.asarray(arrays["articulation"], np.float32)
    if mouth.shape != (frames, len(CHANNELS)) or not np.isfinite(mouth).all():
        raise ValueError(f"its articulation is not {frames} frames of {len(CHANNELS)} finite channels")
    return mouth


def save_arrays(path: Path, arrays: dict[str, NDArray[Any] | np.generic]) -> None:
    """Like numpy.savez_compressed, but the same arrays give the same bytes. Raises OutputError."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, array in arrays.items():
            entry = zipfile.ZipInfo(f"{name}.npy", EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, _npy(array))
    with atomic_path(path) as partial:
        partial.write_bytes(stream.getvalue())


def _npy(array: NDArray[Any] | np.generic) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.asanyarray(array), allow_pickle=False)
    return stream.getvalue()
