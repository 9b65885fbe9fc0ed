"""What the mouth of this head needs to be read: teeth that show, a low tongue, lips that meet and round.

The base mesh has short upper teeth whose edges lie above the line of the lips and face down, so they are dark
and seldom seen; a tongue that fills the mouth up to the palate; lips that rest apart; and a funnel that is a
lozenge. All of it is mended here, by eye, in the millimetres of this head (x to its left, y up from the feet,
z forward). The incisors show 2 mm below the line of the lips and stand in front of the lower ones.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

LIP_LINE = 660.7  # mm, where the lips meet
REST_GAP = (
    (0, 4, 9, 14, 20, 26),
    (0.15, 0.32, 0.35, 0.33, 0.27, 0),
)  # half of it, by distance from the middle
LIP_REACH = (1.0, 7.0)  # mm above and below the line where the whole of it is closed, and nothing

# Of each row of teeth: the middle and the half axes of its arch seen from above (x is 0), and by distance
# forward, the heights of its edge and of its gum.
ARCH = {"teeth_u": (97.0, 31.0, 54.0), "teeth_l": (94.0, 31.0, 52.0)}
INSIDE = 0.75  # of the arch: what lies within is the row's inner side
EDGES = {
    "teeth_u": ((97, 104, 110, 117, 126, 134, 141, 147), (672, 670.4, 668.8, 667.6, 665.7, 664, 661.9, 660)),
    "teeth_l": (
        (96, 103, 110, 117, 126, 134, 141, 147),
        (671.3, 669.4, 668, 666.5, 664.9, 663.1, 661.2, 659.3),
    ),
}
TALL = 17.0  # mm from edge to gum
EDGE_SHIFT = {"teeth_u": -1.7, "teeth_l": 0.0}
FRONT = {"teeth_u": 148.6, "teeth_l": 146.3}  # mm forward, of the middle incisors' faces
BEVEL = 0.9  # mm from the edge to where the face begins: an edge is shaded as it turns inward

# How the tongue lies, by z: how far its underside sinks, and what is left of its height.
TONGUE_Z = (80.0, 100.0, 115.0, 127.0, 140.0)
SINKS = (0.0, 1.0, 2.0, 2.0, 1.0)
NARROWS = ((60.0, 90.0, 110.0, 140.0), (0.9, 0.78, 0.72, 0.8))  # what is left of its width
LEFT = (1.0, 0.85, 0.62, 0.5, 0.6)
UNDERSIDE = (
    (63, 79, 86, 94, 106, 112, 118, 128, 134, 139),
    (650, 629, 636, 639, 646, 654, 657, 657.5, 655, 656),
)

FLATTER = 0.25  # of how far mouthPucker pushes the lips forward

# Rounding, in mm from the middle of the lips: where the skin takes part, by the share of an ellipse about it,
# and how deep behind the front of the face.
ELLIPSE, SHARES, DEPTHS = (52.0, 40.0), (0.42, 1.0), (9.0, 42.0)
FACE_FRONT, FACE_BEND = 157.0, 0.0165  # mm forward at the middle, and its bend by x²
CORNER = 26.0  # mm from the middle
# Of each shape: the share of the base mesh's own pucker that it keeps, how much narrower the mouth is, mm
# forward at the middle, and the share of that at the corners.
PUCKER = (0.35, 0.22, 8.0, 0.65)
FUNNEL = (0.35, 0.2, 7.0, 0.65)
FULLER, LIP_HEIGHT = 0.18, 9.0  # of its height, mm of it: a lip that is drawn in grows as much
HOLE = (
    5.6,
    15.0,
    0.55,
)  # mm of half its height, of half its width at rest, share of it that the upper lip has
HOLE_FADE = (2.0, 22.0)  # mm from the line of the lips
TRUMPET = 1.5  # mm that the rims of the lips turn outward round the hole


def closed_lips(points: Array, opening: Array) -> Array:
    """Skin whose lips touch at rest, (n, 3) metres; `opening` (n, 3) is what jawOpen moves."""
    x, y, z = (points * 1000).T
    lower = np.where(opening[:, 1] * 1000 < -10, 1.0, -1.0)
    near = 1 - _ramp(np.abs(y - LIP_LINE), *LIP_REACH)
    lift = np.interp(np.abs(x), *REST_GAP) * near * _ramp(z, 135, 142) * lower
    return points + _millimetres(0 * x, lift, 0 * x)


def upright_teeth(points: Array, row: str) -> Array:
    """A row of teeth that stands upright and, the upper one, reaches below the lips, (n, 3) metres -> same.

    The strip has four points across at every place of the arch: gum, face, edge, and the inner side.
    """
    x, y, z = (points * 1000).T
    middle, across, ahead = ARCH[row]
    outer = (x / across) ** 2 + ((z - middle) / ahead) ** 2 > INSIDE
    edge = np.interp(z, *EDGES[row])
    up = 1.0 if row == "teeth_u" else -1.0
    along = up * (y - edge) / TALL  # 0 at the edge, about a half on the face, 1 at the gum
    height = np.where(outer & (along > 0.25) & (along < 0.8), edge + up * BEVEL, y) + EDGE_SHIFT[row]
    stand = _ramp(z, 138, 146) * outer
    return np.column_stack([x, height, z + stand * (FRONT[row] - 0.12 * np.abs(x) ** 1.2 / 2 - z)]) / 1000


def low_tongue(points: Array) -> Array:
    """A narrow tongue on the floor of the mouth, its tip behind the lower teeth, (n, 3) metres -> same."""
    _, y, z = (points * 1000).T
    under = np.interp(z, *UNDERSIDE)
    height = under + (y - under) * np.interp(z, TONGUE_Z, LEFT) - np.interp(z, TONGUE_Z, SINKS)
    return np.column_stack([points[:, 0] * np.interp(z, *NARROWS), height / 1000, points[:, 2]])


def flat_stretch(names: tuple[str, ...], deltas: Array) -> Array:
    """The shapes with a mouthStretch that draws the lips back onto the teeth, (targets, n, 3)."""
    shaped, forward = deltas.copy(), deltas[names.index("mouthPucker")] * [0, 0, 1]
    for name in sided("mouthStretch")[1:]:
        shaped[names.index(name)] -= FLATTER * forward
    return shaped


def rounded_lips(names: tuple[str, ...], points: Array, deltas: Array) -> Array:
    """The shapes with lips that round, (n, 3) metres and (targets, n, 3) -> the same.

    mouthPucker draws the corners in and pushes closed lips forward; mouthFunnel does so with a round hole.
    """
    opening, own = deltas[names.index("jawOpen")], deltas[names.index("mouthPucker")]
    shaped = deltas.copy()
    shaped[names.index("mouthPucker")] = PUCKER[0] * own + drawn_in(points, *PUCKER[1:])
    hole = round_hole(points, opening)
    shaped[names.index("mouthFunnel")] = FUNNEL[0] * own + drawn_in(points, *FUNNEL[1:]) + hole
    return shaped


def drawn_in(points: Array, narrower: float, forward: float, corners: float) -> Array:
    """Corners drawn to the middle and lips pushed forward, (n, 3) metres -> (n, 3)."""
    x, y, _ = (points * 1000).T
    near = _round_the_mouth(points)
    aside = np.clip(np.abs(x) / CORNER, 0, 1) ** 2
    fuller = FULLER * near * np.clip(y - LIP_LINE, -LIP_HEIGHT, LIP_HEIGHT)
    return _millimetres(-narrower * near * x, fuller, forward * near * (1 - (1 - corners) * aside))


def round_hole(points: Array, opening: Array) -> Array:
    """Lips parted as an ellipse, their rims turned outward; `opening` (n, 3) is what jawOpen moves."""
    x, y, _ = (points * 1000).T
    middle = -17.0 + 4.5 * np.clip(np.abs(x) / CORNER, 0, 1)  # mm of y that jawOpen moves between the lips
    lower = opening[:, 1] * 1000 < middle
    half, reach, share = HOLE
    round_ = np.sqrt(np.clip(1 - (x / reach) ** 2, 0, 1))
    fade = (1 - _smooth(np.abs(y - LIP_LINE), *HOLE_FADE)) * _round_the_mouth(points)
    apart = half * round_ * fade
    return _millimetres(0 * x, np.where(lower, share - 2, share) * apart, TRUMPET * round_ * fade)


def _round_the_mouth(points: Array) -> Array:
    """Share of a rounding that each point takes, 0 to 1: the lips all of it, cheeks nothing."""
    x, y, z = (points * 1000).T
    off = np.hypot(x / ELLIPSE[0], (y - LIP_LINE) / ELLIPSE[1])
    deep = FACE_FRONT - FACE_BEND * x**2 - z
    return (1 - _smooth(off, *SHARES)) * (1 - _smooth(deep, *DEPTHS))


def sided(name: str) -> tuple[str, ...]:
    """The names under which a shape of both sides may stand."""
    return name, f"{name}Left", f"{name}Right"


def _millimetres(x: Array, y: Array, z: Array) -> Array:
    return np.column_stack([x, y, z]) / 1000


def _ramp(values: Array, low: float, high: float) -> Array:
    """0 below `low`, 1 above `high`, straight between."""
    return np.clip((values - low) / (high - low), 0, 1)


def _smooth(values: Array, low: float, high: float) -> Array:
    """0 below `low`, 1 above `high`, along a cubic between."""
    share = _ramp(values, low, high)
    return np.asarray(share**2 * (3 - 2 * share))
