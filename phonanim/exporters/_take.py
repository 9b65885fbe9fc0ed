"""Build and check the animation of a file; every reader of animations uses it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.decode import (
    MAX_TIME,
    DecodeError,
    decode_file_name,
    decode_list,
    decode_number,
    decode_rate,
    decode_table,
    decode_text,
)
from phonanim.speech.alignment import unpack_intervals

MAX_VALUES, MAX_RATIO = 25_000_000, 4
"""Values of a take from a file of any size, and per byte of a larger file.

Two hours of 50 curves at 60 fps have 22 million. The limit keeps a small file from asking for more.
"""

MAX_CHANNELS = 10_000


def build_take(
    values: NDArray[Any],
    channels: Sequence[str],
    fps: float,
    start: float,
    about: Mapping[str, Any],
    path: Path,
    rig: str = "arkit",
) -> Animation:
    """The animation of (frames, channels) values, with the rig, labels, audio and provenance of `about`.

    The audio is a plain file name, searched next to `path`. Raises DecodeError.
    """
    if values.ndim != 2 or values.dtype.kind not in "fiu" or values.shape[1] != len(channels):
        raise DecodeError(f"its values are {values.dtype}, {values.shape}, for {len(channels)} channels")
    if len(set(channels)) < len(channels):
        twice = next(name for name in channels if channels.count(name) > 1)
        raise DecodeError(f"two of its channels are called {twice!r}")
    for name in channels:
        decode_text(name, "the name of a channel")
    audio = about.get("audio")
    with np.errstate(over="ignore"):  # beyond float32 is infinite, which the animation refuses
        values = np.asarray(values, np.float32)
    return Animation(
        values=values,
        channels=tuple(channels),
        fps=decode_rate(fps),
        rig=decode_text(about.get("rig", rig), "rig"),
        start=decode_number(start, "start"),
        phones=unpack_intervals(decode_list(about.get("phones", []), "phones")),
        words=unpack_intervals(decode_list(about.get("words", []), "words")),
        audio=path.parent / decode_file_name(audio, "audio") if audio else None,
        provenance=dict(decode_table(about.get("provenance", {}), "provenance")),
    )


def take_grid(first: float, last: float, fps: float, n_channels: int, path: Path) -> NDArray[np.float64]:
    """The instants of frames from `first` to `last` seconds, (frames,). Raises DecodeError for too many."""
    span = decode_number(last, "its last key", -MAX_TIME) - decode_number(first, "its first key")
    count = round(span * decode_rate(fps)) + 1
    if count < 1:
        raise DecodeError("its keys run backwards")
    check_size(count, n_channels, path)
    return first + np.arange(count) / fps


def sample_curves(
    grid: NDArray[np.float64], curves: Sequence[tuple[NDArray[Any], NDArray[Any]]]
) -> NDArray[np.float32]:
    """Curves with keys (times, values), interpolated linearly at the instants: (frames, curves)."""
    values = np.empty((len(grid), len(curves)), np.float32)
    for column, (times, keys) in enumerate(curves):
        values[:, column] = np.interp(grid, times, keys)
    return values


def check_times(times: NDArray[np.float64], name: str) -> None:
    """Raise DecodeError unless there are keys at finite times that do not decrease."""
    if times.size == 0:
        raise DecodeError(f"{name} has no keys")
    if not np.isfinite(times).all() or np.abs(times).max() > MAX_TIME:
        raise DecodeError(f"{name} has a key at a time that is not from {-MAX_TIME:g} to {MAX_TIME:g} s")
    if (np.diff(times) < 0).any():
        raise DecodeError(f"{name} has keys that run backwards")


def check_size(frames: int, n_channels: int, path: Path) -> None:
    """Raise DecodeError for more values than a take of such a file may have."""
    most = max(MAX_VALUES, MAX_RATIO * path.stat().st_size)
    if n_channels > MAX_CHANNELS or frames * max(n_channels, 1) > most:
        raise DecodeError(
            f"it asks for {frames} frames of {n_channels} channels; "
            f"such a file has up to {most} values in {MAX_CHANNELS} channels: cut the take in parts"
        )
