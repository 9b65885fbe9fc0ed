"""Sound and phones together: an audio-driven model (regressors/_audio.py) that also gets the phones.

At every step the features of an encoder are concatenated with the phone context of phone-driven models
(phonanim/features/context.py). Sound shows how a line was spoken. Phones show silent closures, and what
comes next.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.encoders import Features
from phonanim.errors import ModelError
from phonanim.features.context import context_features
from phonanim.features.inputs import CONTEXT
from phonanim.media.audio import Sound
from phonanim.regressors import InputModality
from phonanim.regressors._audio import AudioRegressor
from phonanim.regressors._audio_config import Settings
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Config(Settings):
    """The settings of audio-driven models; `beside` is one of phonanim.features.inputs.CONTEXT."""

    beside: str = "gestures"

    def __post_init__(self) -> None:
        if self.beside not in CONTEXT:
            raise ModelError(f"hybrid: beside is {self.beside!r}; use one of {', '.join(CONTEXT)}")


@dataclass(frozen=True)
class FeaturesWithContext(Features):
    """Features of a sound, with the phone context of a track appended to every layer."""

    track: PhoneTrack
    kind: str

    def at(self, times: Array, span: float = 0.0) -> Floats:
        """Both at instants, (times,) seconds -> (times, layers, dims + columns)."""
        audio = super().at(times, span)
        said = context_features(self.track, times, self.kind)
        return np.concatenate([audio, np.repeat(said[:, None], audio.shape[1], axis=1)], axis=2)


@dataclass(frozen=True)
class Hybrid(AudioRegressor):
    """A trained model."""

    input_modality: ClassVar[InputModality] = "both"
    config_class: ClassVar[type] = Config

    def predict(self, track: PhoneTrack | None, times: Array, sound: Sound | None = None) -> Floats:
        """Modes at instants of a track and its sound, (times,) seconds -> (times, modes).

        The shorter of the two is padded with silence. Raises ModelError when either is missing, or the
        encoder is not the one of the training.
        """
        if track is None or sound is None:
            raise ModelError("a hybrid model needs an alignment and a recording")
        return super().predict(track, times, pad_sound(sound, track.duration))

    @classmethod
    def input_features(cls, config: Any, sound: Sound, track: PhoneTrack | None) -> Features:
        """The audio features of a sound with the phone context of its track."""
        assert track is not None
        audio = super().input_features(config, sound, track)
        return FeaturesWithContext(audio.values, audio.rate, audio.start, track, config.beside)


def pad_sound(sound: Sound, end: float) -> Sound:
    """A sound, padded with silence up to `end` seconds if it is shorter."""
    missing = round((end - sound.duration) * sound.rate)
    return replace(sound, samples=np.pad(sound.samples, (0, missing))) if missing > 0 else sound


REGRESSOR = Hybrid
