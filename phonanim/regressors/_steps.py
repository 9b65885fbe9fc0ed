"""The steps of audio-driven models: their times, and the features of a sound at them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.encoders import Encoder, Features, encode, load_encoder
from phonanim.encoders.phones import track_features
from phonanim.encoders.precomputed import Precomputed, read_features
from phonanim.media.audio import Sound
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
FIRST = 0.02  # seconds: the middle of the first frame of 25 fps video is a step, at 25 and at 50 Hz


@lru_cache(maxsize=4)
def cached_encoder(name: str) -> Encoder:
    """An encoder, loaded once."""
    return load_encoder(name)


def sound_features(encoder: Encoder, sound: Sound, track: PhoneTrack | None) -> Features:
    """Features of a sound; phones come from the alignment, unless it is all silence.

    Raises AudioError when precomputed features cannot be read.
    """
    if isinstance(encoder, Precomputed):
        return read_features(sound)
    if encoder.identity.startswith("phones") and track is not None and track.codes.any():
        return track_features(track)
    return encode(encoder, sound)


def step_times(duration: float, rate: float) -> Array:
    """Instants at which a model of a rate predicts, (steps,) seconds."""
    first = FIRST % (1 / rate)
    return first + np.arange(max(1, int(np.floor((duration - first) * rate + 1e-6)) + 1)) / rate


def features_at_steps(features: Features, times: Array, rate: float) -> Floats:
    """Features at steps: interpolated, or averaged if steps are further apart than the features."""
    return features.at(times, 1 / rate)


def interpolate_rows(values: Floats, place: Array) -> Floats:
    """Rows of `values` at fractional indices, interpolated; clamped at the ends."""
    place = np.clip(place, 0, len(values) - 1)
    below = np.floor(place).astype(np.int64)
    share = (place - below).astype(np.float32)[:, None]
    upper = values[np.minimum(below + 1, len(values) - 1)]
    return np.asarray(values[below] + (upper - values[below]) * share, np.float32)
