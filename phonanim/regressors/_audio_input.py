"""Prediction of audio-driven models: encode the sound, then decode its steps in stretches."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from phonanim.encoders import Features
from phonanim.errors import ModelError
from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Tensors
from phonanim.regressors._steps import (
    Array,
    Floats,
    cached_encoder,
    features_at_steps,
    interpolate_rows,
    sound_features,
    step_times,
)
from phonanim.speech.phones import PhoneTrack

CHUNK, AROUND = 60.0, 3.0  # seconds decoded at a time, and seconds of context before and after them


class AudioInput(ABC):
    """Base of the audio-driven regressors: a sound is encoded, and its steps are decoded in stretches.

    `config` has `encoder` and `rate`; `identity` is that of the encoder of the training, `centre` (layers,
    dims) the mean of its features.
    """

    config: Any
    identity: str
    centre: Floats

    input_modality: ClassVar[InputModality] = "audio"
    resumable: ClassVar[bool] = True

    def predict(self, track: PhoneTrack | None, times: Array, sound: Sound | None = None) -> Floats:
        """Modes at instants of a sound, (times,) seconds -> (times, modes), interpolated between steps.

        The same settings give the same bytes. Raises ModelError when the encoder is not the one of the
        training.
        """
        if sound is None:
            raise ModelError("an audio-driven model needs a recording")
        features = self.encode(sound, track)
        grid = step_times(sound.duration, self.config.rate)
        return interpolate_rows(self.modes_at_steps(features, grid), (times - grid[0]) * self.config.rate)

    def encode(self, sound: Sound, track: PhoneTrack | None = None) -> Features:
        """Features of a sound. Raises ModelError when their encoder is not the one of the training."""
        encoder = cached_encoder(self.config.encoder)
        if encoder.identity != self.identity:
            raise ModelError(
                f"the model was trained with {self.identity!r}, but the encoder is {encoder.identity!r}: "
                "set PHONANIM_ENCODERS to its weights, or train it again"
            )
        found = self.input_features(self.config, sound, track)
        self._check_size(found, sound)
        return found

    def _check_size(self, found: Features, sound: Sound) -> None:
        """Raise ModelError when features are not as many as those of the training."""
        layers, dims = found.at(np.zeros(1), 1 / self.config.rate).shape[1:]
        known = self.centre.shape
        if dims != known[1] or (layers != known[0] and known[0] > 1):
            raise ModelError(
                f"{sound.features}: has {layers} layers of {dims} features, the model was trained with "
                f"{known[0]} of {known[1]}"
            )

    @classmethod
    def input_features(cls, config: Any, sound: Sound, track: PhoneTrack | None) -> Features:
        """The features of a sound that models of this kind use; sampled at steps later."""
        return sound_features(cached_encoder(config.encoder), sound, track)

    def modes_at_steps(self, features: Features, grid: Array) -> Floats:
        """Modes at steps, (steps,) seconds of `step_times` -> (steps, modes).

        Each stretch is decoded with its context, so that memory use stays bounded.
        """
        around, size = round(AROUND * self.config.rate), round(CHUNK * self.config.rate)
        found = []
        for begin in range(0, len(grid), size):
            first = max(begin - around, 0)
            values = features_at_steps(features, grid[first : begin + size + around], self.config.rate)
            found.append(self.decode_stretch(values, first)[begin - first :][:size])
        return np.concatenate(found)

    @abstractmethod
    def decode_stretch(self, values: Floats, first: int) -> Floats:
        """Modes of steps from the step `first` on, (steps, layers, dims) -> (steps, modes)."""


def check_sounds(examples: Examples) -> None:
    """Raise ModelError when examples have no recordings."""
    if len(examples.sounds) != len(examples) or not all(examples.sounds):
        raise ModelError("an audio-driven regressor is trained on recordings: give it clips with sound")


def identity_in(tensors: Tensors) -> str:
    """The identity of the encoder in the tensors of a stored model."""
    return tensors["identity"].astype(np.uint8).tobytes().decode()


def fitting(tensors: Tensors, shapes: dict[str, tuple[int, ...]]) -> dict[str, Floats]:
    """The tensors of these names. Raises ValueError when one has another shape."""
    for name, shape in shapes.items():
        if tensors[name].shape != shape:
            raise ValueError(f"{name} is {tensors[name].shape}, not {shape}")
    return {name: tensors[name].astype(np.float32) for name in shapes}
