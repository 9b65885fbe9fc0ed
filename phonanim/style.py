"""Style dials: more or less motion of the whole face, of the jaw, of the lips."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from phonanim.rig import Rig

# mouthClose undoes jawOpen at the lips, so it belongs to the jaw: scaled alike, closed lips stay closed.
JAW = re.compile(r"jaw|mouthClose|lips_?together", re.IGNORECASE)
LIPS = re.compile(r"mouth|lip", re.IGNORECASE)


def dial(
    values: NDArray[np.float32], rig: Rig, intensity: float = 1.0, jaw: float = 1.0, lips: float = 1.0
) -> NDArray[np.float32]:
    """Scale the distance of each control from rest, (frames, controls); 1 changes nothing, 0 holds still.

    `jaw` and `lips` scale the controls that are named after them, `intensity` all; limits are kept. Drawn
    mouths have no more or less, and a share of another control (MetaHuman's Lips Together) is none.
    """
    if rig.visemes is not None and rig.visemes.stepped:
        return values
    gains = intensity * np.array([_gain(name, jaw, lips) for name in rig.controls])
    if rig.through is not None:
        gains[[own for own, _, _ in rig.through.shares]] = 1.0
    if np.all(gains == 1.0):
        return values
    scaled = rig.rest + gains * (values - rig.rest)
    return np.clip(scaled, rig.minimum, rig.maximum).astype(np.float32)


def _gain(control: str, jaw: float, lips: float) -> float:
    if JAW.search(control):
        return jaw
    return lips if LIPS.search(control) else 1.0
