"""The measures of a speaking mouth, and their values over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CHANNELS = (
    "jaw",
    "lip_gap",
    "lip_width",
    "protrusion",
    "upper_lip",
    "lower_lip_to_teeth",
    "tongue_tip_height",
    "tongue_tip_front",
    "tongue_body_height",
    "tongue_body_front",
)
"""The channels, in millimetres.

`jaw` is how far the lower incisors are below where the teeth touch, `lip_gap` the distance of the inner lips
(at or below 0 they touch), `lower_lip_to_teeth` the distance of the lower lip from the edge of the upper
incisors. The others are differences from a closed mouth at rest: wider, further forward, higher. The tongue
is measured in the head, not on the jaw.
"""


@dataclass(frozen=True)
class Articulation:
    """`values` (frames, channels) mm, under `channels`."""

    values: Array
    channels: tuple[str, ...] = CHANNELS

    def channel(self, name: str) -> Array:
        """One channel, (frames,) mm. Raises KeyError for an unknown name."""
        if name not in self.channels:
            raise KeyError(f"no channel {name}; there are {', '.join(self.channels)}")
        return self.values[:, self.channels.index(name)]
