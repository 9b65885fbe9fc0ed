"""What prediction and training of regressors/dynamic_visemes.py share: settings, and where units look."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

# Where in a unit its phones are looked up, as shares of its time; the outer ones see its neighbours.
PLACES = np.array([-0.4, 0.1, 0.3, 0.5, 0.7, 0.9, 1.4])


@dataclass(frozen=True)
class Config:
    """`clusters` is the published number; `doubt`, `join` and `rate` were chosen on validation clips.

    A gesture lasts `shortest` to `longest` seconds. `unit` is what stands for a cluster: its "median",
    the gesture nearest to the centre, or the "mean" of its gestures. `doubt` is the share of the
    probability that phones of the same attribute classes and all phones have in each unit. `step` is
    the grid of seconds on which units may begin.
    """

    clusters: int = 150
    shortest: float = 0.12
    longest: float = 0.6
    unit: Literal["median", "mean"] = "median"
    doubt: float = 0.05
    join: float = 12.0
    rate: float = 10.0
    step: float = 0.04
