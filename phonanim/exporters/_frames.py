"""Frames from time zero on, for formats that count them and know no other start."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.exporters._take import sample_curves

ROUNDING = 1e-6  # frames


def frames_from_zero(animation: Animation, fps: float) -> NDArray[np.float32]:
    """Values at n / fps seconds, (frames, channels); those before the animation's start are its first ones.

    An animation that starts before zero is moved to zero.
    """
    times = animation.times - min(0.0, animation.start)
    if times[0] == 0 and fps == animation.fps:
        return np.asarray(animation.values, np.float32)
    count = int(times[-1] * fps + ROUNDING) + 1
    return sample_curves(np.arange(count) / fps, [(times, curve) for curve in animation.values.T])
