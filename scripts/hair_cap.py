"""The hair of the shipped head: a cap that grows from its scalp, of our own, used by build_head.py."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

# The hair begins above this height (second row) at this distance to the front (first row), in metres.
EDGE = (
    (-0.10, -0.02, 0.015, 0.030, 0.052, 0.060, 0.074, 0.086, 0.104, 0.16),
    (0.655, 0.672, 0.712, 0.744, 0.748, 0.712, 0.708, 0.757, 0.790, 0.803),
)
EAR, EAR_TOP = 0.0755, 0.746  # metres to the side from where, and up to where, there are ears
THICK, FULL = 0.013, 0.040  # metres of hair, and the height above its edge where it is as thick
MARGIN, SINK = 0.012, 0.3  # metres of it below its edge, and how deep that lies under the skin
LOCKS, DEPTH = 26.0, 0.0016  # ridges around the crown, and how deep they are in metres
CROWN = (0.0, 0.84, 0.035)  # where the locks begin
SHADE = 0.45  # of the colour: how much darker the hair is between locks and at its edge


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
    around = np.arctan2(roots[:, 0] - CROWN[0], roots[:, 2] - CROWN[2])
    far = np.linalg.norm(roots - CROWN, axis=1)
    ridge = np.sin(LOCKS * around + 90 * far) * 0.6 + np.sin(LOCKS * 1.7 * around - 40 * far) * 0.4
    sunk = np.clip(over, -MARGIN, 0) * SINK
    height = sunk + THICK * share + DEPTH * ridge * share * np.clip(far / 0.05, 0, 1)
    colors = 1 - SHADE * (0.5 - 0.5 * ridge) * np.clip(far / 0.05, 0, 1) - 0.25 * (1 - share)
    return roots + away * height[:, None], faces, np.repeat(np.clip(colors, 0, 1)[:, None], 3, axis=1)


def above_edge(points: Array) -> Array:
    """How far points lie above the edge of the hair, (n,) metres; ears, which stand out, do not."""
    ear = np.clip((np.abs(points[:, 0]) - EAR) / 0.003, 0, 1) * (points[:, 1] < EAR_TOP)
    return np.asarray(points[:, 1] - np.interp(points[:, 2], *EDGE) - 0.05 * ear)


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
