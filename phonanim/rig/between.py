"""From the controls of one rig to those of another, by the tables of rigs that go through others."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.rig.retarget import limit_controls, move_through
from phonanim.rig.rig import Rig, Through

LEAST = 1e-6  # of a weight; smaller ones are rounding
MOVES = 1e-4  # of a control; less motion is not told as lost

Array = NDArray[np.float64]


def control_matrix(source: Rig, target: Rig) -> Array | None:
    """The change of each of the target's controls per change of the source's, (source's, target's).

    Against the direction of a table it is the least-squares inverse. None where no table leads from one rig
    to the other. Shares of two controls are not linear and are left out.
    """
    if not are_related(source, target):
        return None
    if source.name == target.name:
        return np.eye(len(source.controls))
    steps = np.eye(len(source.controls)) if source.through is None else _inverse(source.through)
    if target.through is not None:
        steps = steps @ _linear(target.through)
    return np.where(np.abs(steps) < LEAST, 0.0, steps)


def are_related(source: Rig, target: Rig) -> bool:
    """Whether both rigs are one, or go through one rig, which may be one of the two."""
    return source.name == target.name or base_rig(source).name == base_rig(target).name


def convert_controls(
    values: NDArray[np.float32], source: Rig, target: Rig
) -> tuple[NDArray[np.float32], tuple[str, ...]]:
    """Curves of one rig as those of another, (frames, source's) -> (frames, target's), within its limits.

    Also returns the moving controls that have no place there. Against a table the curves are those of least
    squares, and shares are undone exactly. The rigs must be related.
    """
    lost: list[str] = []
    base = base_rig(source)
    if source.through is not None and source.name != target.name:
        lost += _lost(values, source, _carries_back(source.through))
        values = _undone(values, source.through)
        values = limit_controls(values, base)
    if target.through is not None and source.name != target.name:
        lost += _lost(values, base, _carries(target.through))
        values = limit_controls(move_through(values, target.through), target)
    return values, tuple(lost)


def base_rig(rig: Rig) -> Rig:
    """The rig that a rig goes through, or itself."""
    return rig if rig.through is None else rig.through.rig


def _linear(through: Through) -> Array:
    """The table without the controls that are shares."""
    table = np.array(through.table, np.float64)
    table[:, [own for own, *_ in through.shares]] = 0.0
    return table


@lru_cache(maxsize=16)
def _inverses(table: bytes, shape: tuple[int, int]) -> Array:
    return np.asarray(np.linalg.pinv(np.frombuffer(table).reshape(shape)), np.float64)


def _inverse(through: Through) -> Array:
    """The other rig's controls per control, (own, other's)."""
    table = _linear(through)
    return _inverses(table.tobytes(), (table.shape[0], table.shape[1]))


def _undone(values: NDArray[np.float32], through: Through) -> NDArray[np.float32]:
    """The inverse of `move_through`, not yet limited."""
    base = values.astype(np.float64) @ _inverse(through)
    for part in {part for _, part, _ in through.shares}:
        found = [values[:, own] * base[:, whole] for own, one, whole in through.shares if one == part]
        base[:, part] = np.mean(found, axis=0)
    return base.astype(np.float32)


def _carries(through: Through) -> NDArray[np.bool_]:
    used = np.asarray((np.abs(_linear(through)) > LEAST).any(axis=1))
    used[[number for _, part, whole in through.shares for number in (part, whole)]] = True
    return used


def _carries_back(through: Through) -> NDArray[np.bool_]:
    used = np.asarray((np.abs(_inverse(through)) > LEAST).any(axis=1))
    used[[own for own, *_ in through.shares]] = True
    return used


def _lost(values: NDArray[np.float32], rig: Rig, carried: NDArray[np.bool_]) -> list[str]:
    moving = np.abs(values - rig.rest).max(axis=0, initial=0.0) > MOVES
    return [rig.controls[number] for number in np.flatnonzero(moving & ~carried)]
