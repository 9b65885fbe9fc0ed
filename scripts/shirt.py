"""The shirt of the shipped head: a knitted collar and shoulders, of our own, used by build_head.py."""

from __future__ import annotations

from typing import Any

import numpy as np
from hair_cap import halved
from numpy.typing import NDArray

Array = NDArray[Any]

# The collar ends at this height (second row) at this distance to the front (first row), in metres.
EDGE = ((-0.06, -0.02, 0.03, 0.06, 0.10), (0.612, 0.609, 0.596, 0.583, 0.575))
SKIN_ABOVE = 0.02  # metres of cloth above its edge, where it lies under the skin
LOOSE, STEEP, SUNK = (
    0.005,
    1.1,
    0.005,
)  # metres of cloth over the skin, how fast it rises, and its hidden part
BAND, ROLL = 0.014, 0.003  # metres: width of the collar, and how much it stands out
# Metres: where the hem begins, how far it hangs below the rim of the skin, and how far it stands out there.
LOWEST, HEM, OUT = 0.545, 0.014, 0.008
RIBS, STITCH = 150.0, 900.0  # ribs of the collar around the neck; rows of stitches per metre
SHADE = 0.30  # of the colour: how much darker it is between stitches and beside the collar


def shirt(points: Array, triangles: Array, normals: Array) -> tuple[Array, Array, Array]:
    """Points (n, 3) metres, triangles (t, 3) and colour factors (n, 3) of a shirt on a skin."""
    below = np.interp(points[:, 2], *EDGE) - points[:, 1]
    faces = triangles[(below[triangles] > -SKIN_ABOVE).any(axis=1)]
    rows = np.unique(faces)
    places = np.zeros(len(points), np.int64)
    places[rows] = np.arange(len(rows))
    base, faces, away = points[rows], places[faces], normals[rows]
    for _ in range(2):
        base, faces, away = halved(base, faces, away)
        away = away / np.linalg.norm(away, axis=1, keepdims=True)
    below = np.interp(base[:, 2], *EDGE) - base[:, 1]
    band = np.clip(1 - ((below - BAND / 2) / (BAND / 2)) ** 2, 0, None)
    height = np.clip(STEEP * below, -SUNK, LOOSE) + ROLL * band
    around = np.arctan2(base[:, 0], base[:, 2] - 0.03)
    inside = (below > 0) & (below < BAND)
    ribs = 0.5 + 0.5 * np.sin(RIBS * around)
    stitches = 0.5 + 0.5 * np.sin(STITCH * base[:, 1]) * np.sin(STITCH * 0.6 * base[:, 0])
    beside = np.exp(-(((below - BAND) / 0.004) ** 2))
    colors = 1 - SHADE * (np.where(inside, ribs, stitches) * 0.5 + beside)
    hem = np.clip((LOWEST - base[:, 1]) / HEM, 0, 1)
    base = base - np.outer(HEM * hem, (0, 1, 0))
    height += OUT * hem
    return base + away * height[:, None], faces, np.repeat(np.clip(colors, 0, 1)[:, None], 3, axis=1)
