"""The tongue: its articulation in millimetres -> a rig's controls.

No camera shows the tongue, so its channels come from phones alone (phonanim/articulation). A rig may name a
table of its tongue, with a row for each control:

- `jaw`: the control that opens the jaw, and what full weight does to the tongue, which rides on it; `amount`
  is its value in a mouth at rest.
- `free`: what full weight does to the tip and the body of the tongue. Least squares of the four measures.
- `dental`: the control that puts the tip between the teeth, by rule, as far as the tip is asked forward;
  `amount` is its value then, `shut` the share of it that is left with the jaw shut.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation import Articulation
from phonanim.core.decode import DecodeError
from phonanim.core.exact import ordered_product
from phonanim.core.files import write_text
from phonanim.core.tables import parse_cell, read_records
from phonanim.errors import RigError
from phonanim.rig.bounded import minimize

Array = NDArray[np.float64]

CHANNELS = ("tongue_tip_height", "tongue_tip_front", "tongue_body_height", "tongue_body_front")
COLUMNS = ("control", "use", "amount", "shut", *CHANNELS)
USES = ("jaw", "free", "dental")
WEIGHTS = np.array([1.0, 0.7, 1.0, 0.4])  # of a millimetre of each channel
SHARED = 4.0  # mm² of a control's square: few controls are used in full
# mm of the tip in front of where a raised body takes it: from the first on it comes between the teeth, and at
# the second it is there.
FORWARD = (3.0, 9.0)
LOWERED = 2.2  # the tip comes down before it comes forward, so that it passes below the upper teeth
OPEN = 0.11  # of the jaw's control, at which the tip has room between the teeth


@dataclass(frozen=True)
class Tongue:
    """A table: `controls` (rows,) as columns of the rig, `uses` (rows,), `amounts`, `shut` (rows,).

    `moved` (rows, 4) mm of CHANNELS at full weight.
    """

    controls: NDArray[np.int64]
    uses: tuple[str, ...]
    amounts: Array
    shut: Array
    moved: Array

    def rows(self, use: str) -> NDArray[np.int64]:
        """The rows of a use."""
        return np.flatnonzero(np.array(self.uses) == use)


@lru_cache(maxsize=64)
def read_tongue(path: Path, controls: tuple[str, ...]) -> Tongue:
    """Read a table of the tongue. Raises RigError naming the row that is wrong."""
    try:
        rows = read_records(path, COLUMNS)
    except (OSError, DecodeError) as error:
        raise RigError(f"{path}: cannot be read: {error}") from error
    places, uses, numbers = [], [], []
    for number, row in rows:
        try:
            places.append(controls.index(row["control"]))
            uses.append(USES[USES.index(row["use"])])
            numbers.append([parse_cell(row[name] or "0", name) for name in COLUMNS[2:]])
        except ValueError as error:
            raise RigError(
                f"{path} row {number}: needs a control of the rig, a use ({', '.join(USES)}) and numbers in "
                f"{', '.join(COLUMNS[2:])} ({error})"
            ) from error
    table = np.array(numbers, np.float64).reshape(-1, len(COLUMNS) - 2)
    return Tongue(np.array(places, np.int64), tuple(uses), table[:, 0], table[:, 1], table[:, 2:])


def write_tongue(path: Path, tongue: Tongue, controls: tuple[str, ...]) -> None:
    """Write a table of the tongue atomically."""
    numbers = np.column_stack([tongue.amounts, tongue.shut, tongue.moved])
    lines = [",".join(COLUMNS)]
    for place, use, row in zip(tongue.controls, tongue.uses, numbers, strict=True):
        lines.append(",".join([controls[place], use, *(f"{round(value, 2) + 0.0:g}" for value in row)]))
    write_text(path, "\n".join(lines) + "\n")


def place_tongue(
    values: NDArray[np.float32], tongue: Tongue, articulation: Articulation
) -> NDArray[np.float32]:
    """Set the tongue's controls, in place, (frames, controls) and (frames, channels) mm -> the controls.

    The jaw is the one that the controls have.
    """
    jaw, free, dental = (tongue.rows(use) for use in USES)
    opened = values[:, tongue.controls[jaw]].astype(np.float64)
    wanted = np.column_stack([articulation.channel(name) for name in CHANNELS])
    wanted = wanted - ordered_product(opened - tongue.amounts[jaw], tongue.moved[jaw])
    between = _between_teeth(articulation) if len(dental) else np.zeros(len(values))
    if len(free):
        solved = _solve(wanted, tongue.moved[free])
        left = np.clip(1 - LOWERED * between, 0, 1)[:, None]
        values[:, tongue.controls[free]] += (solved * left).astype(np.float32)
    room = np.clip(opened.sum(axis=1, keepdims=True) / OPEN, 0, 1) if len(jaw) else np.ones((len(values), 1))
    held = tongue.amounts[dental] * (tongue.shut[dental] + (1 - tongue.shut[dental]) * room)
    values[:, tongue.controls[dental]] += (between[:, None] * held).astype(np.float32)
    return values


def _between_teeth(articulation: Articulation) -> Array:
    """How far the tip is asked between the teeth, 0 to 1, (frames,)."""
    ahead = articulation.channel(CHANNELS[1]) - np.maximum(articulation.channel(CHANNELS[2]), 0)
    return np.clip((ahead - FORWARD[0]) / (FORWARD[1] - FORWARD[0]), 0, 1)


def _solve(wanted: Array, moved: Array) -> Array:
    """Controls from 0 to 1 by bounded least squares, (frames, 4) mm, (controls, 4) -> (frames, controls)."""
    seen = moved * WEIGHTS
    count = len(moved), len(wanted)
    return minimize(
        ordered_product(seen, seen.T) + SHARED * np.eye(len(moved)),
        ordered_product(seen, (wanted * WEIGHTS).T),
        np.zeros(len(moved)),
        np.zeros(count),
        np.ones(count),
        np.zeros(len(moved), bool),
    ).T
