"""Scale articulation: each channel is scaled around the mouth at rest, and contacts are kept."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.channels import CHANNELS, Articulation

Array = NDArray[np.float64]

LIPS = ("lip_gap", "lip_width", "protrusion", "upper_lip")
TEETH_NEAR = 1.5  # mm of jaw: below this, teeth nearly meet (s z sh zh ch jh) and the jaw is not scaled


def scale_articulation(
    articulation: Articulation,
    intensity: float = 1.0,
    jaw: float = 1.0,
    lips: float = 1.0,
    own: Mapping[str, float | Array] | None = None,
    rounding: float = 1.0,
) -> Articulation:
    """Scale channels, (frames, channels) mm; 1 changes nothing, 0 is a closed mouth at rest.

    `intensity` scales jaw and lips, `jaw` and `lips` scale their own channels, `rounding` scales protrusion
    and narrowing of the lips. `own` scales single channels, by one number or by one per frame. Closed lips,
    a lower lip on the teeth and nearly closed teeth stay so. The tongue is not scaled, because it articulates
    by contact.
    """
    gains: dict[str, float | Array] = dict.fromkeys(CHANNELS, 1.0)
    gains |= {"jaw": intensity * jaw} | dict.fromkeys(LIPS, intensity * lips)
    for name, gain in (own or {}).items():
        gains[name] = gains[name] * gain
    width = articulation.channel("lip_width")
    gains["protrusion"] = gains["protrusion"] * rounding
    gains["lip_width"] = gains["lip_width"] * np.where(width < 0, rounding, 1.0)
    moved = {name: gain for name, gain in gains.items() if np.ndim(gain) or gain != 1.0}
    if all(np.all(np.asarray(gain) == 1.0) for gain in moved.values()):
        return articulation
    values = articulation.values.copy()
    for name, gain in moved.items():
        values[:, articulation.channels.index(name)] *= gain
    drop, near = articulation.channel("jaw"), np.minimum(gains["jaw"], 1.0) * TEETH_NEAR
    beyond = gains["jaw"] * np.maximum(drop - TEETH_NEAR, 0)
    values[:, articulation.channels.index("jaw")] = np.minimum(drop, TEETH_NEAR) * near / TEETH_NEAR + beyond
    gap = articulation.channel("lip_gap")
    values[:, articulation.channels.index("lip_gap")] = np.where(gap > 0, gains["lip_gap"] * gap, gap)
    return Articulation(values, articulation.channels)
