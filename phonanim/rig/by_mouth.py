"""From the controls of one rig to those of another by what both do to a mouth, where no table leads there.

Both rigs know how many millimetres each control moves the measures of the mouth (phonanim/rig/measures.py). A
change of a control of one rig becomes the change of the other's controls that moves the mouth most alike.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.rig.measures import USES, MouthMeasures
from phonanim.rig.morphs import plain_name
from phonanim.rig.pronounce import WEIGHTS
from phonanim.rig.rig import Rig
from phonanim.rig.visemes import vowel_shapes
from phonanim.speech.inventory import INVENTORY, SILENCE

Array = NDArray[np.float64]

MOVES = 0.05  # mm of a measure; less motion of the mouth is not seen
FIRM = 20.0  # mm² of a control's square, so that none works against another; set by eye
SMALL = 0.01  # of a weight; smaller changes are left out


def mouth_matrix(source: Rig, target: Rig) -> tuple[Array, Array]:
    """The change of the target's controls per change of the source's, and how much of it that is.

    (source's, target's), and (source's,) from 0 to 1: the share of the motion of the mouth that the target
    can show, in weighted squared millimetres. Controls of one name are the same in both. 0 where neither
    holds.
    """
    matrix = np.zeros((len(source.controls), len(target.controls)))
    shares = np.zeros(len(source.controls))
    if source.mouth is not None and target.mouth is not None:
        _match_mouths(source, source.mouth, target, target.mouth, matrix, shares)
    names = {plain_name(name): column for column, name in enumerate(target.controls)}
    for row, name in enumerate(source.controls):
        if (column := names.get(plain_name(name))) is not None:
            matrix[row] = 0.0
            matrix[row, column] = shares[row] = 1.0
    if target.visemes is not None and not target.visemes.stepped:
        silent = int(target.visemes.of[INVENTORY.code(SILENCE), 0])
        matrix[:, silent] -= matrix.sum(axis=1)  # weights add up to 1, and silence has the rest
    return matrix, shares


def _match_mouths(
    source: Rig, given: MouthMeasures, target: Rig, own: MouthMeasures, matrix: Array, shares: Array
) -> None:
    """Fill the rows of controls that move the mouth."""
    weights = np.sqrt(WEIGHTS["free"])
    moving = own.uses[:, USES.index("free")]
    if target.visemes is not None:  # consonants' shapes show where their phones are
        vowels = vowel_shapes(target.visemes, len(target.controls))
        moving = moving & (_spread(target, own)[:, vowels] > 0).any(axis=1)
    seen = own.moved[moving] * weights
    inverse = np.linalg.solve(seen @ seen.T + FIRM * np.eye(len(seen)), seen)
    spread = _spread(target, own)[moving]
    for names, moved in zip(given.names, given.moved, strict=True):
        wanted = moved * weights / len(names)
        if np.abs(moved).max() < MOVES * len(names):
            continue
        found = inverse @ wanted
        found[np.abs(found) < SMALL] = 0.0
        left = ((wanted - found @ seen) ** 2).sum() / (wanted**2).sum()
        for name in names:
            row = source.controls.index(name)
            matrix[row], shares[row] = found @ spread, max(1.0 - left, 0.0)


def _spread(rig: Rig, measures: MouthMeasures) -> Array:
    """The controls of each unknown, (unknowns, controls)."""
    return np.array([np.isin(rig.controls, names) for names in measures.names], np.float64)
