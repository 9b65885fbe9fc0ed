"""Shapes of the shipped head's tongue that ARKit has no names for: where phones are made in the mouth.

ARKit's only tongue shape is tongueOut. These five move the tongue to the places of articulation of the IPA
chart: the tip between the teeth (dental) and to the ridge behind them (alveolar), the blade to the hard
palate (palatal), the back to the soft one (velar), all of it drawn back and bunched (rhotic). At full weight
they arrive with the jaw a little open (ARKit jawOpen 0.11), since the tongue rides on it. They are our own,
drawn in the millimetres of this head.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

TIP_HEIGHT = 653.5  # mm, the middle of the tip at rest


def tongue_shapes(points: Array) -> dict[str, Array]:
    """Motions of the tongue by name, (n, 3) metres -> (n, 3) metres each."""
    x, y, z = (points * 1000).T
    back, front = (
        _hump(z, at, wide) * _hump(x, 0, 20) * _ramp(y, 644, 656) for at, wide in ((92, 15), (103, 22))
    )
    return {
        "tongueBackUp": _millimetres(0 * x, 14 * back, -3 * back),
        "tongueFrontUp": _millimetres(0 * x, 12 * front, 5 * front + 2 * _ramp(z, 80, 139)),
        "tongueTipBack": _drawn_back(x, y, z),
        "tongueTipForward": _between_the_teeth(x, y, z),
        "tongueTipUp": _to_the_ridge(x, y, z),
    }


def lifted_out(points: Array, out: Array) -> Array:
    """ARKit's tongueOut for a tongue that lies low: over the lower teeth, not through them, (n, 3) metres."""
    x, y, z = (points * 1000).T
    along = _ramp(z, 105, 139)
    level = 14.0 * along**1.3 - 0.6 * along * (y - TIP_HEIGHT) - along * out[:, 1] * 1000
    return out + _millimetres(0 * x, level, 0 * x)


def _to_the_ridge(x: Array, y: Array, z: Array) -> Array:
    """The tip up behind the upper teeth, with its underside low enough to be seen below their edge."""
    along = _ramp(z, 111, 136)
    bent = along**1.2 * _hump(x, 0, 24) * (0.1 + 0.9 * _ramp(y, 652.5, 656))
    return _millimetres(0 * x, 16.5 * bent, 1.5 * along)


def _drawn_back(x: Array, y: Array, z: Array) -> Array:
    """The tip drawn back and up, the middle bunched."""
    along = _ramp(z, 72, 139)
    bunched = _hump(z, 118, 20) * _hump(x, 0, 22) * _ramp(y, 644, 656)
    return _millimetres(0 * x, 7 * bunched, -14 * along)


def _between_the_teeth(x: Array, y: Array, z: Array) -> Array:
    """The tip stretched forward, flat and narrow, over the lower teeth and under the upper ones."""
    along = _ramp(z, 112, 139)
    thinner = -0.7 * along * (y - TIP_HEIGHT)
    return _millimetres(-0.45 * along * x, thinner + 6.9 * along**1.2, 18.5 * along)


def _millimetres(x: Array, y: Array, z: Array) -> Array:
    return np.column_stack([x, y, z]) / 1000


def _ramp(values: Array, low: float, high: float) -> Array:
    """0 below `low`, 1 above `high`, straight between."""
    return np.clip((values - low) / (high - low), 0, 1)


def _hump(values: Array, middle: float, breadth: float) -> Array:
    return np.exp(-(((values - middle) / breadth) ** 2))
