"""The audio-driven model with one decoder, trained by `regressors/_torch_audio.py`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from phonanim.core.neural import softmax
from phonanim.errors import ModelError
from phonanim.regressors._audio_config import Settings
from phonanim.regressors._audio_input import AudioInput
from phonanim.regressors._decoders import decode
from phonanim.regressors._steps import Floats


@dataclass(frozen=True)
class AudioModel(AudioInput):
    """A trained model: `centre` and `scale` (layers, dims) of the features, `mix` (layers,) for all layers.

    `weights` are the decoder's (regressors/_decoders.py); `identity` is the encoder's in training.
    """

    config: Settings
    centre: Floats
    scale: Floats
    mix: Floats
    weights: dict[str, Floats]
    identity: str

    config_class: ClassVar[type] = Settings

    def with_settings(self, **settings: Any) -> AudioModel:
        """The same model with another `style`. Raises ModelError for a style or setting that it lacks."""
        for name, value in settings.items():
            if name != "style":
                raise ModelError(f"the model does not sample: leave out --{name}")
            if not 0 <= value < self.config.styles:
                raise ModelError(f"style is {value}; the model has 0 to {self.config.styles - 1}")
        return replace(self, config=replace(self.config, **settings))

    def decode_stretch(self, values: Floats, first: int) -> Floats:
        """Modes of steps, (steps, layers, dims) -> (steps, modes)."""
        return decode(self.config, self.weights, self.mix_layers(values)[None])[0]

    def mix_layers(self, values: Floats) -> Floats:
        """The input of the decoder, (steps, layers, dims) -> (steps, dims)."""
        normal = (values - self.centre) * self.scale
        return (
            normal[:, -1]
            if self.config.inputs == "enc"
            else np.einsum("sld,l->sd", normal, self.layer_shares)
        )

    @property
    def layer_shares(self) -> Floats:
        """The weight of each layer, (layers,), sum 1 (Medina 2023, eq. 4.14)."""
        return softmax(self.mix)
