"""Edits that were made on one rig, as edits of another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.edits import Edit, Edits
from phonanim.rig import Rig
from phonanim.rig.between import base_rig, control_matrix
from phonanim.rig.by_mouth import mouth_matrix

SHOWN = 4  # names in a note
LEAST = 0.3  # share of its motion below which an edit is not carried; set by eye


def carry_edits(edits: Edits, source: Rig, target: Rig) -> tuple[Edits, tuple[str, ...]]:
    """The edits on the controls of another rig, and notes on what could not be carried.

    They are carried by a table that leads there, or else by what both rigs do to the mouth. An offset is
    carried to every control that moves with it, a replacement where the other rig's control follows this one
    alone. Where there is neither, edits are kept by the names of their channels.
    """
    way = _way(source, target)
    if way is None or source.name == target.name:
        return edits, ()
    matrix, shares = way.matrix, way.shares
    found: list[Edit] = []
    homeless: list[str] = []
    mixed: list[str] = []
    for edit in edits.edits:
        row = source.controls.index(edit.channel) if edit.channel in source.controls else None
        if row is None or shares[row] < LEAST:
            homeless.append(edit.channel)
            continue
        carried = list(_carried(edit, row, matrix, target))
        found += carried
        if not carried:
            mixed.append(edit.channel)
    told = dict.fromkeys(edit.channel for edit in edits.edits if edit.channel not in homeless)
    parts = [f"{name} {shares[source.controls.index(name)]:.0%}" for name in told if not way.exact]
    how = "its table" if way.exact else "what both do to the mouth"
    notes = [f"the edits were made on the rig {source.name} and carried to {target.name} by {how}"]
    if parts:
        notes[0] += f", of which it shows {_named(parts)}"
    if homeless:
        notes.append(f"edits of {_named(homeless)} were left out: {target.name} has nothing for them")
    if mixed:
        notes.append(
            f"edits of {_named(mixed)} were left out: {target.name} mixes what they replace with other "
            "curves; find the edits without --replace"
        )
    notes += _share_notes(edits, source, target)
    return replace(edits, rig=target.name, edits=tuple(found)), tuple(notes)


@dataclass(frozen=True)
class _Way:
    """`matrix` (source's, target's) of changes, `shares` (source's,) of the motion that is carried."""

    matrix: NDArray[np.float64]
    shares: NDArray[np.float64]
    exact: bool


def _way(source: Rig, target: Rig) -> _Way | None:
    """How edits go from one rig to another; None where only the names of channels are left."""
    matrix = control_matrix(source, target)
    if matrix is not None:
        return _Way(matrix, np.asarray(matrix.any(axis=1), np.float64), True)
    first, last = base_rig(source), base_rig(target)
    middle, shares = mouth_matrix(first, last)
    there, on = control_matrix(source, first), control_matrix(last, target)
    if there is None or on is None or not middle.any():
        return None
    weights = np.abs(there)
    carried = np.asarray(weights @ shares / np.maximum(weights.sum(axis=1), 1e-9), np.float64)
    return _Way(there @ middle @ on, carried, False)


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
