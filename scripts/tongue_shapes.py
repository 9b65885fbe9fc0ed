"""Shapes of the shipped head's tongue that ARKit has no names for: where phones are made in the mouth.

ARKit's only tongue shape is tongueOut. These four move the tongue to the places of articulation of the IPA
chart: the tip between the teeth (dental) and to the ridge behind them (alveolar), the blade to the hard
palate (palatal), the back to the soft one (velar). At full weight they arrive with the jaw a little open
(ARKit jawOpen 0.15), since the tongue rides on it. They are our own, drawn in the millimetres of this head.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def tongue_shapes(points: Array) -> dict[str, Array]:
    """Motions of the tongue by name, (n, 3) metres -> (n, 3) metres each."""
    x, y, z = (points * 1000).T
    back, front = (_hump(z, at, 15) * _hump(x, 0, 20) * _ramp(y, 648, 662) for at in (92, 119))
    return {
        "tongueBackUp": _millimetres(0 * x, 12 * back, -3 * back),
        "tongueFrontUp": _millimetres(0 * x, 9 * front, 2 * front),
        "tongueTipForward": _between_the_teeth(x, y, z),
        "tongueTipUp": _to_the_ridge(x, y, z),
    }


def _to_the_ridge(x: Array, y: Array, z: Array) -> Array:
    """The tip up behind the upper teeth, with its underside low enough to be seen below their edge."""
    along = _ramp(z, 111, 136)
    bent = along**1.2 * _hump(x, 0, 24) * (0.35 + 0.65 * _ramp(y, 655, 663))
    return _millimetres(0 * x, 15.0 * bent, 0.5 * along)


def _between_the_teeth(x: Array, y: Array, z: Array) -> Array:
    """The tip stretched forward, flat and narrow, over the lower teeth."""
    along = _ramp(z, 118, 139)
    flat = _ramp(z, 118, 132)
    thinner = -0.62 * flat * (y - 659)
    return _millimetres(-0.3 * along * x, thinner + 3.4 * flat, 12.5 * along)


def _millimetres(x: Array, y: Array, z: Array) -> Array:
    return np.column_stack([x, y, z]) / 1000


def _ramp(values: Array, low: float, high: float) -> Array:
    """0 below `low`, 1 above `high`, straight between."""
    return np.clip((values - low) / (high - low), 0, 1)


def _hump(values: Array, middle: float, breadth: float) -> Array:
    return np.exp(-(((values - middle) / breadth) ** 2))
