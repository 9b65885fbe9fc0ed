"""Articulation in millimetres against articulation: channel by channel, in speech."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.articulation import CHANNELS
from phonanim.metrics import correlation, regression_slope, sd_ratio

Array = NDArray[np.float64]
CHANNEL_OF = {
    "aperture": "lip_gap",
    "width": "lip_width",
    "protrusion": "protrusion",
    "upper_lip": "upper_lip",
}
"""The channel of each lip curve of a surface."""


def articulation_of(animation: Animation) -> dict[str, Array]:
    """The channels of articulation of a take, (frames,) mm each; empty where it has none.

    They are those that the take carries, or its controls where its rig is articulation itself.
    """
    if animation.articulation is not None:
        return dict(zip(CHANNELS, animation.articulation.T.astype(np.float64), strict=True))
    if not set(animation.channels) <= set(CHANNELS):
        return {}
    return {name: animation.channel(name).astype(np.float64) for name in animation.channels}


def channel_measures(
    ours: Mapping[str, Array], theirs: Mapping[str, Array], speech: NDArray[np.bool_], in_mm: bool = True
) -> dict[str, float]:
    """R, slope, ratio of deviations and error of each channel that both have, over frames of speech.

    The error is the root mean square after the mean difference is taken off, since every sensor and every
    face has its own zero. Where the unit of `theirs` is unknown, `in_mm` is false, and only r has a meaning.
    """
    measures: dict[str, float] = {}
    for name, curve in theirs.items():
        if name not in ours:
            continue
        pair = ours[name][speech], curve[speech]
        measures[f"articulation_{name}_r"] = correlation(*pair)
        if in_mm:
            measures[f"articulation_{name}_slope"] = regression_slope(*pair)
            measures[f"articulation_{name}_sd_ratio"] = sd_ratio(*pair)
            measures[f"articulation_{name}_rmse_mm"] = float(np.std(np.subtract(*pair)))
    return measures


def channel_error(ours: Mapping[str, Array], theirs: Mapping[str, Array], speech: NDArray[np.bool_]) -> Array:
    """Mean over common channels of the difference's size, without its mean in speech, (frames,) mm."""
    apart = [ours[name] - theirs[name] for name in theirs if name in ours]
    return np.mean([np.abs(each - each[speech].mean()) for each in apart], axis=0)
