"""Measures of the upper face of a take: blinks and brow raises per minute, eye and head motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.life.layer import ACROSS
from phonanim.rig.morphs import plain_name
from phonanim.rig.neck import TURNS

Array = NDArray[np.float64]

SHUT = 0.5  # weight from which an eye is closed
RAISED = 0.08  # weight from which a brow is raised
EYES = ("eyelookoutleft", "eyelookinleft", "eyelookinright", "eyelookoutright")


def upper_face_measures(animation: Animation) -> dict[str, float]:
    """Statistics of a take with ARKit's controls, by name, for the controls that it has.

    `blinks_per_min` and `brow_raises_per_min` count how often lids and inner brows rise above a threshold.
    `gaze_sd_deg` is the standard deviation of horizontal gaze, `head_sd_deg` that of the head's three
    rotations together, the root of the sum of their variances.
    """
    curves = {
        plain_name(name): row.astype(float)
        for name, row in zip(animation.channels, animation.values.T, strict=True)
    }
    minutes = len(animation.values) / animation.fps / 60
    found: dict[str, float] = {}
    if {"eyeblinkleft", "eyeblinkright"} <= curves.keys():
        lids = (curves["eyeblinkleft"] + curves["eyeblinkright"]) / 2
        found["blinks_per_min"] = rises(lids, SHUT) / minutes
    if "browinnerup" in curves:
        found["brow_raises_per_min"] = rises(curves["browinnerup"], RAISED) / minutes
    if set(EYES) <= curves.keys():
        out_left, in_left, in_right, out_right = (curves[name] for name in EYES)
        found["gaze_sd_deg"] = float(ACROSS * (out_left - in_left + in_right - out_right).std() / 2)
    turns = [curves[plain_name(name)] for name in TURNS if plain_name(name) in curves]
    if turns:
        found["head_sd_deg"] = float(np.sqrt(np.var(turns, axis=1).sum()))
    return found


def rises(curve: Array, threshold: float) -> int:
    """How often a curve, (frames,), rises above a threshold."""
    return int(((curve[1:] > threshold) & (curve[:-1] <= threshold)).sum())
