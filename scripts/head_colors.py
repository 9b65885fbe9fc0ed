"""Colours of the skin of the shipped head: lips, inner mouth, brows, lids and scalp; see build_head.py."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from head_file import Part
from numpy.typing import NDArray

Array = NDArray[Any]

# What the vertex colours multiply the skin by.
LIPS = (0.78, 0.50, 0.48)
LASHES, LID = (0.35, 0.25, 0.22), (0.70, 0.95)  # and the part of the way of the edge of a lid, from and to
INNER_MOUTH = (0.38, 0.12, 0.12)
HAIR = (0.16, 0.13, 0.12)
DEEP = (0.18, 0.12, 0.12)  # tongue and teeth as they lie in the dark
LIT, DARK = 0.012, 0.055  # metres from the tip of the tongue, or from between the front teeth

# An eyebrow in metres: its reach from the middle, its height along that, its half thickness at both ends.
BROW_START, BROW_END, BROW_FRONT = 0.011, 0.056, 0.08
BROW_ARC = ((0.0, 0.55, 1.0), (0.7500, 0.7560, 0.7515))
BROW_THICKNESS = (0.0042, 0.0018)
BROW_DENSITY = 0.95

# Cropped hair grows above this height (second row) at this distance to the front (first row), in metres.
HAIRLINE = ((-0.10, -0.02, 0.05, 0.09, 0.16), (0.70, 0.735, 0.755, 0.800, 0.815))
HAIR_FADE, HAIR_DENSITY = 0.03, 0.85


def lashed(part: Part, names: tuple[str, ...]) -> Part:
    """The skin with dark edges of the upper lids: what moves farthest as the eyes close."""
    amount = np.zeros(len(part.points))
    for name in ("eyeBlinkLeft", "eyeBlinkRight"):
        down = -part.deltas[names.index(name)][:, 1]
        amount = np.maximum(amount, np.clip((down / down.max() - LID[0]) / (LID[1] - LID[0]), 0, 1))
    return replace(part, colors=part.colors * tinted(amount[:, None], LASHES))


def tinted(amount: Array, color: tuple[float, float, float]) -> Array:
    """Factors that multiply a colour: one where the amount is 0, `color` where it is 1."""
    return 1 + amount * (np.array(color) - 1)


def brows(points: Array) -> Array:
    """How much brow there is at each point of the skin, 0 to 1: an arc over each eye."""
    along = (np.abs(points[:, 0]) - BROW_START) / (BROW_END - BROW_START)
    height = np.interp(along, *BROW_ARC)
    across = np.abs(points[:, 1] - height) / np.interp(along, [0, 1], BROW_THICKNESS)
    inside = (along > -0.05) & (along < 1.05) & (points[:, 2] > BROW_FRONT)
    return np.clip(1.5 - across, 0, 1) * inside * BROW_DENSITY


def scalp(points: Array) -> Array:
    """How much cropped hair there is at each point of the skin, 0 to 1."""
    over = points[:, 1] - np.interp(points[:, 2], *HAIRLINE)
    return np.clip(over / HAIR_FADE, 0, 1) * HAIR_DENSITY
