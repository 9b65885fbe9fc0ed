"""The effect of each rig control on the measures of a mouth, in millimetres of the reference face.

Blendshapes add up linearly, so this table holds all that a solver needs from a mesh: jaw drop, lip gap at
four places from the middle to the corner, width and protrusion. It is measured on the head once and stored
beside the rig as a CSV.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError
from phonanim.core.files import write_text
from phonanim.core.tables import parse_cell, read_records
from phonanim.errors import RigError

Array = NDArray[np.float64]

MEASURES = (
    "jaw",
    "gap",
    "gap_inner",
    "gap_outer",
    "gap_corner",
    "width",
    "protrusion",
    "upper_lip",
    "lower_lip_up",
    "lower_lip_forward",
)
"""Drop of the lower incisors; distance of the inner lips in the middle and at three places towards the
corner; distance of the corners; upper lip forward and up; lower lip up and forward. At rest, the last two are
measured from the edge of the upper incisors, the gaps from contact, the others from rest."""
REST = "rest"
USES = ("free", "closed", "tucked", "pressed", "shared")
"""When a control is used: for free lips, for closed lips, for a lower lip on the teeth, or only to press lips
that already touch. Weights of controls that are `shared`, such as visemes, add up to 1 at most."""


@dataclass(frozen=True)
class MouthMeasures:
    """`names` (unknowns) of controls that move as one; `moved` (unknowns, measures) mm at full weight.

    `rest` (measures,) mm is the mouth at rest; `effort` (unknowns,) is the cost of full weight, in mm²;
    `uses` (unknowns, USES) is when each is used.
    """

    names: tuple[tuple[str, ...], ...]
    uses: NDArray[np.bool_]
    effort: Array
    moved: Array
    rest: Array


def read_measures(path: Path, controls: tuple[str, ...]) -> MouthMeasures:
    """Read a table of measures. Raises RigError naming the row that is wrong."""
    columns = ("effort", *MEASURES)
    try:
        rows = read_records(path, ("controls", "uses", *columns))
    except (OSError, DecodeError) as error:
        raise RigError(f"{path}: cannot be read: {error}") from error
    names, uses, table = [], [], []
    for number, row in rows:
        try:
            names.append(tuple(row["controls"].split()))
            uses.append([row["uses"].split().count(use) for use in USES])
            table.append([parse_cell(row[key] or "0", key) for key in columns])
        except DecodeError as error:
            raise RigError(
                f"{path} row {number}: needs controls, uses, effort, {', '.join(MEASURES)} ({error})"
            ) from error
        unknown = [name for name in names[-1] if name not in controls and number > 2]
        if unknown:
            raise RigError(
                f"{path} row {number}: names the control {unknown[0]!r}, which the rig does not have"
            )
    if not names or names[0] != (REST,):
        raise RigError(f"{path}: its first row must be {REST!r}, the mouth at rest")
    values = np.array(table)
    return MouthMeasures(
        tuple(names[1:]), np.array(uses[1:], bool), values[1:, 0], values[1:, 1:], values[0, 1:]
    )


def write_measures(path: Path, measures: MouthMeasures) -> None:
    """Write a table of measures atomically."""
    lines = [",".join(("controls", "uses", "effort", *MEASURES))]
    lines.append(_line(REST, "", 0.0, measures.rest))
    for row, names in enumerate(measures.names):
        uses = " ".join(use for use, used in zip(USES, measures.uses[row], strict=True) if used)
        lines.append(_line(" ".join(names), uses, measures.effort[row], measures.moved[row]))
    write_text(path, "\n".join(lines) + "\n")


def _line(names: str, uses: str, effort: float, moved: Array) -> str:
    return ",".join([names, uses, *(f"{round(value, 3) + 0.0:g}" for value in (effort, *moved))])
