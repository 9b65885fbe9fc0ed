"""The hair of the shipped head: combed to the side from a parting, of our own, used by build_head.py."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

# The hair begins above this height (second row) at this distance to the front (first row), in metres.
EDGE = (
    (-0.10, -0.02, 0.015, 0.030, 0.052, 0.060, 0.074, 0.086, 0.104, 0.16),
    (0.660, 0.680, 0.722, 0.746, 0.748, 0.730, 0.734, 0.766, 0.792, 0.805),
)
FRINGE, STRANDS = (
    0.0028,
    ((260.0, 0.4), (570.0, 0.3), (910.0, 0.3)),
)  # metres by which the edge is uneven, and its waves
EAR, EAR_TOP = 0.0755, 0.746  # metres to the side from where, and up to where, there are ears
FULL = 0.030  # metres above its edge where the hair is as thick as it gets
# Metres of hair: on the sides, and what is added on the top, most ahead of the crown.
SIDES, TOP, HIGH = 0.006, 0.013, (0.78, 0.85)
MARGIN, SINK = 0.012, 0.3  # metres of it below its edge, and how deep that lies under the skin
PARTING, GROOVE = 0.036, 0.004  # metres to the character's left, and half the width of the groove
# Waves of locks along the way that they are combed, per metre, with their shares; and their depth in metres.
LOCKS, DEPTH = ((240.0, 0.4), (410.0, 0.3), (730.0, 0.3)), 0.0016
CURVE = 0.9  # how far back locks lie for each metre that they are away from the parting
SHADE = 0.50  # of the colour: how much darker the hair is between locks and at its edge


def hair_cap(points: Array, triangles: Array, normals: Array) -> tuple[Array, Array, Array]:
    """Points (n, 3) metres, triangles (t, 3) and colour factors (n, 3) of the hair on a skin."""
    over = above_edge(points)
    faces = triangles[(over[triangles] > -MARGIN).any(axis=1)]
    rows = np.unique(faces)
    places = np.zeros(len(points), np.int64)
    places[rows] = np.arange(len(rows))
    roots, faces, away = points[rows], places[faces], normals[rows]
    for _ in range(2):
        roots, faces, away = halved(roots, faces, away)
        away = away / np.linalg.norm(away, axis=1, keepdims=True)
    over = above_edge(roots)
    share = np.clip(over / FULL, 0, 1)
    share = np.sqrt(share * (2 - share))
    above = np.clip((roots[:, 1] - HIGH[0]) / (HIGH[1] - HIGH[0]), 0, 1)
    above = above**2 * (3 - 2 * above)
    ridge, groove = combed(roots)
    thick = (SIDES + TOP * above) * (1 - 0.3 * groove * above)
    height = np.clip(over, -MARGIN, 0) * SINK + share * (thick + DEPTH * ridge * (0.4 + 0.6 * above))
    colors = 1 - SHADE * (0.5 - 0.5 * ridge) - 0.22 * (1 - share) - 0.35 * groove * above
    return roots + away * height[:, None], faces, np.repeat(np.clip(colors, 0, 1)[:, None], 3, axis=1)


def combed(points: Array) -> tuple[Array, Array]:
    """The ridges of locks, (n,) -1 to 1, and how near points are to the parting, (n,) 0 to 1."""
    aside = np.abs(points[:, 0] - PARTING)
    along = points[:, 2] + CURVE * aside + 0.4 * (points[:, 1] - 0.8)
    ridge = sum(share * np.sin(wave * along + 2 * number) for number, (wave, share) in enumerate(LOCKS))
    return np.asarray(ridge), np.exp(-((aside / GROOVE) ** 2))


def above_edge(points: Array) -> Array:
    """How far points lie above the edge of the hair, (n,) metres; ears, which stand out, do not."""
    ear = np.clip((np.abs(points[:, 0]) - EAR) / 0.003, 0, 1) * (points[:, 1] < EAR_TOP)
    uneven = sum(share * np.sin(wave * (points[:, 0] + 0.5 * points[:, 2])) for wave, share in STRANDS)
    return np.asarray(points[:, 1] - np.interp(points[:, 2], *EDGE) - 0.05 * ear - FRINGE * uneven)


def halved(points: Array, triangles: Array, values: Array) -> tuple[Array, Array, Array]:
    """Every triangle as four, with points and values in the middles of its edges."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, numbers = np.unique(edges, axis=0, return_inverse=True)
    middles = len(points) + numbers.reshape(-1, 3)
    (a, b, c), (ab, bc, ca) = triangles.T, middles.T
    faces = np.concatenate(
        [np.column_stack(t) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    )
    return (
        np.concatenate([points, points[unique].mean(axis=1)]),
        faces,
        np.concatenate([values, values[unique].mean(axis=1)]),
    )
