"""Articulation from sound alone, for audio-driven models: a linear map from the features of an encoder.

It learns what phones say of the articulation of the training clips (trajectories.py), so it has jaw, teeth
and rounding that no landmarks show, and it needs no phones when it is used. Ridge regression on the
encoder's last layers now, and a little before and after.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.blend import silence_and_rounding
from phonanim.articulation.channels import CHANNELS
from phonanim.articulation.table import read_targets
from phonanim.articulation.trajectories import articulate
from phonanim.encoders import Encoder, Features, encode, load_encoder
from phonanim.encoders.precomputed import Precomputed, read_features
from phonanim.errors import ModelError
from phonanim.media.audio import Sound
from phonanim.speech.gestures import GESTURES
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Tensors = dict[str, NDArray[np.generic]]

OFFSETS = (-0.12, 0.0, 0.12)  # seconds
LAYERS = 2  # the last ones of the encoder
RIDGE = 0.3  # in variances of a feature, for each frame
OUTPUTS = len(CHANNELS) + 2  # and how silent and how rounded the mouth is
FLOOR = 1e-6  # least of what is added, for a feature that never changes
BLOCK = 4096  # frames at a time, so that their features fit in memory
LIVE, READING = "mfcc_live", "phones"  # encoders that read too little ahead, and that read phones


@dataclass(frozen=True)
class AudioArticulation:
    """The map: `weights` (features, OUTPUTS) of features less `mean`, and `offset` (OUTPUTS,).

    `encoder` is its name, `identity` that of its weights.
    """

    encoder: str
    identity: str
    mean: NDArray[np.float32]
    weights: NDArray[np.float32]
    offset: NDArray[np.float32]

    def at(self, sound: Sound, times: Array) -> tuple[Array, Array, Array]:
        """Articulation (frames, channels) mm, silence (frames,) and rounding (frames,) at seconds.

        Where silence is all but sure, the mouth is at rest.
        Raises ModelError when the encoder is not the one of the training.
        """
        encoder = _encoder(self.encoder)
        if encoder.identity != self.identity:
            raise ModelError(
                f"the articulation was learned with {self.identity!r}, but the encoder is "
                f"{encoder.identity!r}: set PHONANIM_ENCODERS to its weights, or train the model again"
            )
        features, values = _read(encoder, sound), np.empty((len(times), OUTPUTS))
        for start in range(0, len(times), BLOCK):
            rows = slice(start, start + BLOCK)
            values[rows] = (_features(features, times[rows]) - self.mean) @ self.weights + self.offset
        silent, rounded = np.clip(values[:, len(CHANNELS) :], 0, 1).T
        mouth = values[:, : len(CHANNELS)]
        rest = read_targets().target[GESTURES.names.index("sil")]
        mouth += np.clip(2 * silent - 1, 0, 1)[:, None] * (rest - mouth)
        return mouth, silent, rounded

    def tensors(self) -> Tensors:
        """The map, by name."""
        texts = {"encoder": self.encoder, "identity": self.identity}
        coded = {name: np.frombuffer(text.encode(), np.uint8) for name, text in texts.items()}
        return coded | {"mean": self.mean, "weights": self.weights, "offset": self.offset}

    @classmethod
    def from_tensors(cls, tensors: Tensors) -> AudioArticulation:
        """The map that `tensors` describe. Raises ModelError when they do not match."""
        try:
            encoder, identity = (
                tensors[name].astype(np.uint8).tobytes().decode() for name in ("encoder", "identity")
            )
            mean, weights, offset = (
                tensors[name].astype(np.float32) for name in ("mean", "weights", "offset")
            )
        except (KeyError, ValueError) as error:
            raise ModelError(f"articulation.safetensors: is damaged ({error}); train it again") from error
        if weights.shape != (len(mean), OUTPUTS) or mean.ndim != 1 or offset.shape != (OUTPUTS,):
            raise ModelError("articulation.safetensors: its shapes do not match; train the model again")
        return cls(encoder, identity, mean, weights, offset)


def can_predict_articulation(encoder: str) -> bool:
    """Whether a map can be learned: not for live encoders, whose streams know no sound ahead."""
    return encoder not in (LIVE, READING, "")


def fit_audio_articulation(
    encoder: str, clips: Iterable[tuple[PhoneTrack, Array, Sound]]
) -> AudioArticulation:
    """Learn from clips: their phones, instants (frames,) seconds, and sounds."""
    known = _encoder(encoder)
    sums = [np.zeros(()) for _ in range(5)]  # of frames, inputs, targets, and their products
    for track, times, sound in clips:
        seen = _features(_read(known, sound), times).astype(np.float64)
        silent, rounded = silence_and_rounding(track, times)
        wanted = np.column_stack([articulate(track, times).values, silent, rounded])
        found = len(times), seen.sum(axis=0), wanted.sum(axis=0), seen.T @ seen, seen.T @ wanted
        sums = [total + new for total, new in zip(sums, found, strict=True)]
    count = float(sums[0])
    mean, offset, square, product = (total / count for total in sums[1:])
    square, product = square - np.outer(mean, mean), product - np.outer(mean, offset)
    ridge = np.maximum(RIDGE * np.diag(square), FLOOR)
    weights = np.linalg.solve(square + np.diag(ridge), product)
    parts = (part.astype(np.float32) for part in (mean, weights, offset))
    return AudioArticulation(encoder, known.identity, *parts)


@lru_cache(maxsize=2)
def _encoder(name: str) -> Encoder:
    return load_encoder(name)


def _read(encoder: Encoder, sound: Sound) -> Features:
    """Features of a sound; those of another program come from its file."""
    return read_features(sound) if isinstance(encoder, Precomputed) else encode(encoder, sound)


def _features(features: Features, times: Array) -> NDArray[np.float32]:
    """Features around instants, (frames,) seconds -> (frames, features)."""
    around = [features.at(times + offset)[:, -LAYERS:].reshape(len(times), -1) for offset in OFFSETS]
    return np.concatenate(around, axis=1)
