"""Accents for what landmarks cannot show: a lower lip rolled under the teeth, and lip protrusion.

A face tracker follows the rims of the lips. It cannot detect the teeth, measures little lip protrusion, and a
network predicts a mean. The motion of f v and of rounded phones on a rig is therefore too weak. A rig may
name a table of accents (phones, control, amount) that are added during such a phone. They rise and fall like
the contacts (phonanim/face/contacts.py).
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError
from phonanim.core.tables import parse_cell, read_records
from phonanim.errors import RigError
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

CORE = 0.3  # share of the phone that has the full accent
RAMP = 0.08  # seconds before and after it


@lru_cache(maxsize=64)
def read_accents(path: Path, controls: tuple[str, ...]) -> NDArray[np.float32]:
    """A table of accents as amounts (41, controls). Raises RigError naming the row that is wrong."""
    table = np.zeros((len(INVENTORY.phones), len(controls)), np.float32)
    try:
        rows = read_records(path, ("phones", "control", "amount"))
    except (OSError, DecodeError) as error:
        raise RigError(f"{path}: cannot be read: {error}") from error
    for number, row in rows:
        try:
            codes = INVENTORY.codes(row["phones"].split())
            table[codes, controls.index(row["control"])] = parse_cell(row["amount"], "amount")
        except (KeyError, ValueError) as error:
            raise RigError(
                f"{path} row {number}: needs phones, a control of the rig and an amount ({error})"
            ) from error
    return table


def add_accents(
    values: NDArray[np.float32], accents: NDArray[np.float32], track: PhoneTrack, times: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Add accents to controls at `times` (frames,) seconds, in place, (frames, controls) -> the same.

    Where two phones are near, each control takes the larger accent.
    """
    added = np.zeros_like(values)
    for segment in np.flatnonzero(accents[track.codes].any(axis=1)):
        begin, end = track.bounds[segment : segment + 2]
        middle, half = (begin + end) / 2, (end - begin) / 2 * CORE
        first, last = np.searchsorted(times, (middle - half - RAMP, middle + half + RAMP))
        away = np.clip((np.abs(times[first:last] - middle) - half) / RAMP, 0, 1)
        envelope = ((1 + np.cos(np.pi * away)) / 2).astype(np.float32)
        accent = envelope[:, None] * accents[track.codes[segment]]
        np.maximum(added[first:last], accent, out=added[first:last])
    values += added
    return values
