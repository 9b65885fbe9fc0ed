"""Settings of regressors/dynamic_visemes.py, and the places in a unit at which phones are sampled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from phonanim.regressors._styles import check_style

# Where the phones of a unit are sampled, as shares of its time; the outer positions are in its neighbours.
PLACES = np.array([-0.4, 0.1, 0.3, 0.5, 0.7, 0.9, 1.4])


@dataclass(frozen=True)
class Config:
    """`clusters` is the published number; `doubt`, `join` and `rate` were chosen on validation clips.

    A gesture lasts `shortest` to `longest` seconds. `unit` is the representative of a cluster: its "median",
    the gesture nearest to the centre, or the "mean" of its gestures. `doubt` is the share of the probability
    that each unit gives to phones of the same attribute classes and to all phones. `step` is the grid of
    seconds on which units may begin. `style` is the style of the output, out of the `styles` of
    Examples.styles, which differ in their mean.
    """

    clusters: int = 150
    shortest: float = 0.12
    longest: float = 0.6
    unit: Literal["median", "mean"] = "median"
    doubt: float = 0.05
    join: float = 12.0
    rate: float = 10.0
    step: float = 0.04
    styles: int = 1
    style: int = 0

    def __post_init__(self) -> None:
        check_style("dynamic_visemes", self)
