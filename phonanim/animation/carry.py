"""Edits that were made on one rig, as edits of another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.edits import Edit, Edits
from phonanim.rig import Rig
from phonanim.rig.between import control_matrix

SHOWN = 4  # names in a note


def carry_edits(edits: Edits, source: Rig, target: Rig) -> tuple[Edits, tuple[str, ...]]:
    """The edits on the controls of another rig, and notes on what could not be carried.

    An offset is carried to every control that the table names. A replacement is carried where the other rig's
    control follows this one alone. Where no table leads there, edits are kept by the names of their channels.
    """
    matrix = control_matrix(source, target)
    if matrix is None or source.name == target.name:
        return edits, ()
    found: list[Edit] = []
    homeless: list[str] = []
    mixed: list[str] = []
    for edit in edits.edits:
        if edit.channel not in source.controls:
            homeless.append(edit.channel)
            continue
        row = source.controls.index(edit.channel)
        carried = list(_carried(edit, row, matrix, target))
        found += carried
        if not matrix[row].any():
            homeless.append(edit.channel)
        elif not carried:
            mixed.append(edit.channel)
    notes = [f"the edits were made on the rig {source.name} and carried to {target.name} by its table"]
    if homeless:
        notes.append(f"edits of {_named(homeless)} were left out: {target.name} has nothing for them")
    if mixed:
        notes.append(
            f"edits of {_named(mixed)} were left out: {target.name} mixes what they replace with other "
            "curves; find the edits without --replace"
        )
    notes += _share_notes(edits, source, target)
    return replace(edits, rig=target.name, edits=tuple(found)), tuple(notes)


def _carried(edit: Edit, row: int, matrix: NDArray[np.float64], target: Rig) -> Iterator[Edit]:
    for column in np.flatnonzero(matrix[row]):
        weight = float(matrix[row, column])
        if edit.kind == "replace" and np.count_nonzero(matrix[:, column]) > 1:
            continue
        values = tuple(value * weight for value in edit.values)
        yield replace(edit, channel=target.controls[column], values=values)


def _share_notes(edits: Edits, source: Rig, target: Rig) -> list[str]:
    """A note where a control of the other rig is a share of two that were edited."""
    if target.through is None or target.through.rig.name != source.name:
        return []
    edited = {edit.channel for edit in edits.edits}
    controls = target.through.rig.controls
    shares = [
        target.controls[own]
        for own, part, whole in target.through.shares
        if edited & {controls[part], controls[whole]}
    ]
    return [f"{_named(shares)} depend on the share of two curves and keep their own motion"] if shares else []


def _named(names: Sequence[str]) -> str:
    unique = list(dict.fromkeys(names))
    more = f" and {len(unique) - SHOWN} more" if len(unique) > SHOWN else ""
    return ", ".join(unique[:SHOWN]) + more
