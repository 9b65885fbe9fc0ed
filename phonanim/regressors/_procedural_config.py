"""Common part of prediction and training of regressors/procedural.py: settings, and nearby gestures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.regressors._styles import check_style
from phonanim.speech.gestures import GESTURES, split_parts
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
REACH = 5  # gestures on either side that have an effect
SHORT, LONG = 0.01, 0.2  # seconds; durations are clamped to these for dominance
TABLES = ("target", "strength", "onset", "offset")


@dataclass(frozen=True)
class Config:
    """`own` and `shared` are the ridge penalties of a gesture's individual part and of the articulation's.

    `style` is the style of the output, out of the `styles` of Examples.styles, which differ in their mean.
    """

    steps: int = 600
    batch: int = 4096
    rate: float = 0.03
    own: float = 1e-2
    shared: float = 1e-4
    styles: int = 1
    style: int = 0

    def __post_init__(self) -> None:
        check_style("procedural", self)


@dataclass(frozen=True)
class Neighbours:
    """The gestures around instants, each (times, 2 REACH + 1); `begin`, `end` in seconds relative to them."""

    gesture: NDArray[np.int64]
    begin: NDArray[np.float32]
    end: NDArray[np.float32]
    exists: NDArray[np.bool_]


def neighbours(track: PhoneTrack, times: Array) -> Neighbours:
    """The gestures that have an effect at instants, (times,) seconds."""
    parts = split_parts(track)
    here = np.clip(np.searchsorted(parts.bounds, times, side="right") - 1, 0, len(parts.parts) - 1)
    around = here[:, None] + np.arange(-REACH, REACH + 1)
    exists = (around >= 0) & (around < len(parts.parts))
    around = np.clip(around, 0, len(parts.parts) - 1)
    return Neighbours(
        GESTURES.part_gesture[parts.parts[around]],
        (parts.bounds[around] - times[:, None]).astype(np.float32),
        (parts.bounds[around + 1] - times[:, None]).astype(np.float32),
        exists,
    )
