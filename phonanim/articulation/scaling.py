"""More or less articulation: each channel scaled around the mouth at rest, with its contacts kept."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from phonanim.articulation.channels import CHANNELS, Articulation

LIPS = ("lip_gap", "lip_width", "protrusion", "upper_lip")
TEETH_NEAR = 1.5  # mm of jaw: less is teeth that nearly meet (s z sh zh ch jh), which stay as they are


def scale_articulation(
    articulation: Articulation,
    intensity: float = 1.0,
    jaw: float = 1.0,
    lips: float = 1.0,
    own: Mapping[str, float] | None = None,
) -> Articulation:
    """Scale channels, (frames, channels) mm; 1 changes nothing, 0 is a closed mouth at rest.

    `intensity` scales jaw and lips, `jaw` and `lips` theirs, `own` single channels. Lips that touch, a lower
    lip on the teeth and teeth that nearly meet stay so; the tongue, which finds its places by contact, keeps.
    """
    gains = dict.fromkeys(CHANNELS, 1.0) | {"jaw": intensity * jaw} | dict.fromkeys(LIPS, intensity * lips)
    for name, gain in (own or {}).items():
        gains[name] *= gain
    if all(gain == 1.0 for gain in gains.values()):
        return articulation
    values = articulation.values * [gains[name] for name in articulation.channels]
    drop, near = articulation.channel("jaw"), min(gains["jaw"], 1.0) * TEETH_NEAR
    beyond = gains["jaw"] * np.maximum(drop - TEETH_NEAR, 0)
    values[:, articulation.channels.index("jaw")] = np.minimum(drop, TEETH_NEAR) * near / TEETH_NEAR + beyond
    gap = articulation.channel("lip_gap")
    values[:, articulation.channels.index("lip_gap")] = np.where(gap > 0, gains["lip_gap"] * gap, gap)
    return Articulation(values, articulation.channels)
