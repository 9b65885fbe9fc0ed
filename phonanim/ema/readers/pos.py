"""Carstens .pos: positions as the AG500 (no header) and the AG501 (with one) compute them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from phonanim.ema.articulation import Articulation
from phonanim.ema.readers import first_bytes
from phonanim.errors import CorpusError

MARK = b"AG50xDATA_V"
FIELDS = 7  # x, y, z in mm, phi, theta in degrees, the error of the fit, and one more: little-endian float32
AG500_CHANNELS, AG500_RATE = 12, 200.0  # the AG500 writes no header


def recognizes(path: Path) -> bool:
    """Whether the file has the suffix or the first bytes of Carstens files."""
    return path.suffix.lower() == ".pos" or first_bytes(path, len(MARK)) == MARK


def read(path: Path) -> Articulation:
    """The channels, named by their number from 1. Raises CorpusError when the file is damaged.

    The second line of an AG501 file is the size of the header in bytes; lines of NAME=VALUE follow. A
    channel exactly at the origin was not tracked.
    """
    data = first_bytes(path, -1)
    try:
        size, channels, rate = _header(data) if data.startswith(MARK) else (0, AG500_CHANNELS, AG500_RATE)
    except (KeyError, IndexError, ValueError) as error:
        raise CorpusError(f"{path}: its header is damaged ({error}); fetch it again") from error
    frame = 4 * FIELDS * channels
    if len(data) <= size or (len(data) - size) % frame:
        raise CorpusError(
            f"{path}: is truncated: {max(0, len(data) - size)} bytes are not whole samples of {frame}"
        )
    table = np.frombuffer(data, "<f4", offset=size).reshape(-1, channels, FIELDS)
    positions = table[..., :3].astype(np.float64)
    positions[~positions.any(axis=2)] = np.nan
    return Articulation(tuple(str(n + 1) for n in range(channels)), positions, rate, source=str(path))


def _header(data: bytes) -> tuple[int, int, float]:
    """Size in bytes, channels and rate."""
    size = int(data.split(b"\n", 2)[1])
    lines = data[:size].decode("latin-1").splitlines()[2:]
    fields = {
        name.strip(): value for name, equals, value in (line.partition("=") for line in lines) if equals
    }
    channels, rate = int(fields["NumberOfChannels"]), float(fields["SamplingFrequencyHz"])
    if size < 1 or channels < 1 or not rate > 0:
        raise ValueError(f"{channels} channels at {rate:g} Hz")
    return size, channels, rate
