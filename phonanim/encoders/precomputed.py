"""Features that another program has computed: an array in a file beside the recording.

For encoders whose weights cannot be had here (wav2vec 1.0, DeepSpeech 2), or that run elsewhere. The features
of NAME.wav lie in NAME.features.npy, or in the file that `phonanim animate --features` names.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import read_array
from phonanim.encoders import STEPS, Features
from phonanim.errors import AudioError
from phonanim.media.audio import Sound

SUFFIX = ".features.npy"
RATES = (50.0, 100.0, 25.0, 30.0, 60.0)  # steps per second; the first that fits
SPARE = 3  # steps that an encoder may drop at the ends
LARGEST = float(np.finfo(np.float16).max)


@dataclass(frozen=True)
class Precomputed:
    """The encoder that runs nothing: its features are read."""

    layers: int = 1
    dims: int = 0
    identity: str = "precomputed"
    start: float = 0.5 / STEPS
    window: int = 10
    margin: int = 0

    def run(self, samples: NDArray[np.float32]) -> NDArray[np.float32]:
        """Raises AudioError: samples alone tell no features."""
        raise AudioError(
            f"precomputed features belong to a file: put them beside the recording as NAME{SUFFIX}, "
            "or name them with --features"
        )


def read_features(sound: Sound) -> Features:
    """The features of a recording from its file, (steps, dims) or (steps, layers, dims).

    The rate is the one of RATES at which the steps cover the recording; step k is at (k + 0.5) / rate s.
    Raises AudioError when there is no file, when it is not such an array, or when no rate fits.
    """
    path = sound.features
    if path is None or not path.is_file():
        where = f"{path}: there is no such file" if path else "the recording has no file of features"
        raise AudioError(f"{where}; put them beside it as NAME{SUFFIX}, or name them with --features")
    values = _read_array(path)
    for rate in RATES:
        if abs(len(values) - sound.duration * rate) <= SPARE:
            return Features(values, rate, 0.5 / rate)
    known = ", ".join(f"{rate:g}" for rate in sorted(RATES))
    raise AudioError(
        f"{path}: has {len(values)} steps for {sound.duration:.2f} s of sound; give {known} per second"
    )


def _read_array(path: Path) -> NDArray[np.float16]:
    try:
        found = read_array(path)
    except (OSError, ValueError) as error:
        raise AudioError(f"{path}: cannot be read as an array ({error}); save it with numpy.save") from error
    if found.ndim not in (2, 3) or found.dtype.kind not in "fiu":
        raise AudioError(f"{path}: must hold numbers of the shape (steps, dims) or (steps, layers, dims)")
    if found.size == 0 or not np.isfinite(found).all():
        raise AudioError(f"{path}: has numbers that are not finite, or none at all; compute it again")
    values = found if found.ndim == 3 else found[:, None]
    return np.clip(values, -LARGEST, LARGEST).astype(np.float16)


def load() -> Precomputed:
    """The encoder."""
    return Precomputed()
