"""Tracks of the Edinburgh Speech Tools, the articulography format of mngu0 and MOCHA-TIMIT."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import read_bounded
from phonanim.datasets import Frames
from phonanim.errors import CorpusError

MAX_BYTES = 1 << 28  # of a track

MARK, END = b"EST_File Track", b"EST_Header_End\n"
BEFORE = 2  # columns before the channels: time, and whether the frame is valid


@dataclass(frozen=True)
class Track:
    """`values` (frames, channels) at `times` (frames,) seconds; missing frames are NaN."""

    times: NDArray[np.float64]
    values: NDArray[np.float32]
    names: tuple[str, ...]


def read_est(path: Path) -> Track:
    """Read a track, text or binary. Raises CorpusError when it is not a track, or is truncated."""
    try:
        data = read_bounded(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        raise CorpusError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from error
    head, end, body = data.partition(END)
    if not (data.startswith(MARK) and end):
        raise CorpusError(f"{path}: is not an EST track; its first line is not {MARK.decode()!r}")
    fields = dict(
        line.split(None, 1) for line in head.decode("latin-1").splitlines() if len(line.split()) > 1
    )
    try:
        names = tuple(fields[f"Channel_{i}"].strip() for i in range(int(fields["NumChannels"])))
        table = _table(fields, body, BEFORE + len(names))
    except (KeyError, ValueError) as error:
        raise CorpusError(f"{path}: is damaged ({error}); fetch it again") from error
    values = np.where(table[:, 1:2] > 0, table[:, BEFORE:], np.nan).astype(np.float32)
    return Track(table[:, 0].astype(np.float64), values, names)


def _table(fields: dict[str, str], body: bytes, columns: int) -> NDArray[np.float64]:
    if fields["DataType"].strip() == "ascii":
        table = np.array(body.split(), float).reshape(-1, columns)
    else:
        order = ">" if fields.get("ByteOrder", "").strip() == "10" else "<"
        table = np.frombuffer(body, f"{order}f4").astype(float).reshape(-1, columns)
    frames = int(fields["NumFrames"])
    if len(table) < max(2, frames):
        raise ValueError(f"{len(table)} frames of {frames}")
    if not np.median(np.diff(table[:, 0])) > 0:
        raise ValueError("its times do not increase")
    return table[: frames or None]


def sensors(path: Path, channels: Mapping[str, tuple[str, ...]], scale: float) -> Frames:
    """Sensors of a track in mm, (frames, sensors, axes): the channels of each, times `scale`.

    Sensors that are not in the track are left out. Raises CorpusError when none is left.
    """
    track = read_est(path)
    kept = {name: axes for name, axes in channels.items() if set(axes) <= set(track.names)}
    if not kept:
        wanted = ", ".join(axes[0] for axes in channels.values())
        raise CorpusError(f"{path}: has none of the channels {wanted}; it has {', '.join(track.names)}")
    columns = [[track.names.index(channel) for channel in axes] for axes in kept.values()]
    fps = float(round(1 / np.median(np.diff(track.times)), 3))
    return Frames((track.values[:, columns] * scale).astype(np.float32), fps, tuple(kept), "mm")
