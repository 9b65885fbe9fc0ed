"""The tongue by place of articulation: a prior where there are no data.

Cameras do not show the tongue, so a model of the face does not move it. A rig may name a table of places
(gesture, control, amount, shut) that maps each articulation of `lexicon/gestures.csv` to controls. Each
gesture is held in the middle of its time. Between gestures the tongue glides, also through phones that leave
it free (p b m f v h), so that it is already in place for the next phone while the lips are closed.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import RigError
from phonanim.speech.gestures import GESTURES, split_parts
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]

GLIDE = 0.06  # largest part of a gesture, in seconds, for the glide on either side
SHARE = 0.42  # of its time, at most
# The jaw opening at which amounts apply; the tongue moves with the jaw and rises less when it is closed.
JAW, OPEN = "jawOpen", 0.11
RESTING = ("silence", "vowel")  # gestures that place the tongue even where the table has no amount


@dataclass(frozen=True)
class Places:
    """Amounts of the controls in each gesture, (gestures, controls).

    `free` (gestures,) marks gestures that leave the tongue free; `shut` (controls,) is the share of an amount
    that remains with the jaw closed.
    """

    amounts: Array
    free: NDArray[np.bool_]
    shut: Array


@lru_cache(maxsize=64)
def read_places(path: Path, controls: tuple[str, ...]) -> Places:
    """Read a table of places. Raises RigError naming the row that is wrong."""
    table, shut = np.zeros((len(GESTURES.columns), len(controls))), np.ones(len(controls))
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError) as error:
        raise RigError(f"{path}: cannot be read: {error}") from error
    for number, row in enumerate(rows, start=2):
        try:
            control = controls.index(row["control"])
            table[GESTURES.columns.index(row["gesture"]), control] = float(row["amount"])
            shut[control] = float(row["shut"])
        except (KeyError, ValueError, AttributeError, TypeError) as error:
            raise RigError(
                f"{path} row {number}: needs a column of gestures.csv, a control of the rig, an amount and "
                f"the share of it with the jaw shut ({error})"
            ) from error
    known = table.any(axis=1) | np.isin(GESTURES.columns, RESTING)
    articulation = GESTURES.articulation.astype(np.float64)
    free = np.asarray(articulation[:, known].sum(axis=1) == 0)
    return Places((articulation @ table).clip(0, 1), free, shut)


def place_tongue(
    values: NDArray[np.float32],
    places: Places,
    controls: tuple[str, ...],
    track: PhoneTrack,
    times: Array,
) -> NDArray[np.float32]:
    """Add the tongue to controls at `times` (frames,) seconds, in place, (frames, controls) -> the same."""
    moved = _glide(*_held(places, track), times)
    if JAW in controls:
        opened = np.clip(values[:, [controls.index(JAW)]] / OPEN, 0, 1)
        moved *= places.shut + (1 - places.shut) * opened
    values += moved.astype(np.float32)
    return values


def _held(places: Places, track: PhoneTrack) -> tuple[Array, Array]:
    """When the tongue is held, (2 gestures,) seconds, and the controls then, (2 gestures, controls)."""
    parts = split_parts(track)
    gestures = GESTURES.part_gesture[parts.parts]
    bound = ~places.free[gestures]
    begin, end, gestures = parts.bounds[:-1][bound], parts.bounds[1:][bound], gestures[bound]
    glide = np.minimum(SHARE * (end - begin), GLIDE)
    return np.column_stack([begin + glide, end - glide]).ravel(), np.repeat(
        places.amounts[gestures], 2, axis=0
    )


def _glide(knots: Array, held: Array, times: Array) -> Array:
    """Cosine interpolation between knots, (knots,), (knots, controls), (frames,) -> (frames, controls)."""
    if len(knots) == 0:
        return np.zeros((len(times), held.shape[1]))
    after = np.searchsorted(knots, times, side="right").clip(1, len(knots) - 1)
    length = np.maximum(knots[after] - knots[after - 1], 1e-9)
    eased = (1 - np.cos(np.pi * np.clip((times - knots[after - 1]) / length, 0, 1))) / 2
    return np.asarray(held[after - 1] + eased[:, None] * (held[after] - held[after - 1]))
