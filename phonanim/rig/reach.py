"""How far a head's shapes can go: the best that any weights within their limits give, measure by measure.

A linear program for each instant (blendshapes add up linearly): the value of a measure nearest to the
reference's while the lips part as the reference's do and, for protrusion, are as narrow. Each control is used
when phonanim/rig/pronounce.py uses it: a rolled lip on the teeth, what presses in closed mouths, what spreads
not in round ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation import Articulation
from phonanim.rig.measures import MEASURES, USES, MouthMeasures
from phonanim.rig.pronounce import CHANNEL_OF, Limits, mouth_limits
from phonanim.rig.rig import Rig

Array = NDArray[np.float64]

COLUMN = {channel: name for name, channel in CHANNEL_OF.items()} | {"lip_gap": "gap"}
FIRST = {
    "lip_gap": (),
    "lip_width": ("lip_gap",),
    "protrusion": ("lip_gap", "lip_width"),
    "jaw": ("lip_gap",),
}
"""What keeps to the reference before a measure is asked for."""
WITHIN = {"lip_gap": 1.0, "lip_width": 2.0}  # mm from the reference that count as keeping to it
STEP = 5  # every fifth instant is looked at
FIRM = 10.0  # how much more a millimetre beyond WITHIN costs than one of the measure itself


def reachable_slopes(
    articulation: Articulation, rig: Rig, measures: MouthMeasures, shown: Mapping[str, Array]
) -> dict[str, float]:
    """The greatest slope of each measure against what a reference has shown, (frames,) mm by channel.

    Values beyond the reference's do not count. Empty without scipy.
    """
    try:
        from scipy.optimize import linprog
    except ImportError:
        return {}
    found = {}
    limits = mouth_limits(articulation, rig, measures)
    for name in FIRST:
        wanted = np.asarray(shown[name], float)[::STEP]
        frames = range(0, len(shown[name]), STEP)
        best = np.array([_nearest(linprog, limits, measures, shown, name, frame) for frame in frames])
        centred = wanted - wanted.mean()
        found[name] = float((best - best.mean()) @ centred / max(float(centred @ centred), 1e-12))
    return found


def _nearest(
    linprog: Any,
    within: Limits,
    measures: MouthMeasures,
    shown: Mapping[str, Array],
    name: str,
    frame: int,
) -> float:
    """The value of a measure nearest to the reference's at a frame, mm."""
    low, highest, under = within
    count, firsts = len(low), FIRST[name]
    size = (
        count + 1 + len(firsts)
    )  # the weights, how far the measure is, and how far what comes first is beyond
    rows, limits = [], []

    def near(channel: str, slack: int, within: float) -> None:
        column = MEASURES.index(COLUMN[channel])
        goal = float(shown[channel][frame]) - measures.rest[column]
        for sign in (1.0, -1.0):
            row = np.zeros(size)
            row[:count], row[slack] = sign * measures.moved[:, column], -1.0
            rows.append(row)
            limits.append(sign * goal + within)

    near(name, count, 0.0)
    for number, first in enumerate(firsts):
        near(first, count + 1 + number, WITHIN[first])
    shared = np.zeros(size)
    shared[:count] = measures.uses[:, USES.index("shared")]
    rows.append(shared)
    limits.append(1.0)
    for lower, upper in under:
        pair = np.zeros(size)
        pair[lower], pair[upper] = 1.0, -1.0
        rows.append(pair)
        limits.append(0.0)
    cost = np.concatenate([np.zeros(count), [1.0], np.full(len(firsts), FIRM)])
    bounds = [*zip(low, highest[frame], strict=True), *[(0, None)] * (1 + len(firsts))]
    solved = linprog(cost, A_ub=np.array(rows), b_ub=limits, bounds=bounds, method="highs")
    column = MEASURES.index(COLUMN[name])
    return float(measures.moved[:, column] @ solved.x[:count] + measures.rest[column])
