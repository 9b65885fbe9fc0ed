"""The inputs of regressors by name: the one place that converts a track and instants into numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.features.context import N_BOXES, N_TIMING, context_features, part_table
from phonanim.features.indicators import WIDTH, indicators, n_indicators, raw_indicators
from phonanim.features.windows import TICK
from phonanim.speech.inventory import N_PHONES
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
MODEL_FPS = 25.0  # frames per second of the recordings; windows of frames are defined on this grid
STEP = 1 / MODEL_FPS  # seconds
CONTEXT = ("all", "gestures", "classes")
FEATURES = ("indicators", "raw", *CONTEXT)
NO_CLUSTERS = np.full((N_PHONES, N_PHONES), -1, np.int8)


def window_features(
    kind: str,
    track: PhoneTrack,
    times: Array,
    clusters: NDArray[np.int8] = NO_CLUSTERS,
    reach: int = WIDTH,
) -> NDArray[np.float32]:
    """Features around instants, (times,) seconds -> (times, features).

    "indicators" and "raw" are those of Taylor 2017 (supplement 1; section 5.2) over `reach` frames (Kx) of
    the model's grid; "all", "gestures" and "classes" are the context features. Raises ValueError for another
    kind.
    """
    if kind in CONTEXT:
        return context_features(track, times, kind)
    if kind == "indicators":
        return indicators(frame_codes(track, times, reach), clusters).dense()
    if kind == "raw":
        return raw_indicators(frame_codes(track, times, reach)).dense()
    raise ValueError(f"there are no features {kind!r}; use one of {', '.join(FEATURES)}")


def n_features(kind: str, reach: int = WIDTH) -> int:
    """Number of columns of `window_features`."""
    if kind in CONTEXT:
        return N_BOXES * int(part_table(kind).shape[1]) + N_TIMING
    return {"indicators": n_indicators(reach), "raw": N_PHONES * reach}[kind]


def frame_codes(track: PhoneTrack, times: Array, width: int = WIDTH) -> NDArray[np.uint8]:
    """Phones in the frames around instants, (times,) -> (times, width) codes; clamped at the ends.

    An instant on a boundary belongs to the phone that begins there, regardless of rounding.
    """
    around = times[:, None] + (np.arange(width) - width // 2) * STEP + TICK
    return track.sample(np.clip(around, 0, track.duration - TICK).ravel()).reshape(around.shape)
