"""Common part of the audio-driven regressors: an encoder makes features, a decoder maps them to modes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from phonanim.core.neural import tensors_with_prefix
from phonanim.regressors import Examples, Progress, Tensors
from phonanim.regressors._audio_input import check_sounds, fitting, identity_in
from phonanim.regressors._audio_model import AudioModel
from phonanim.regressors._decoders import decoder_shapes
from phonanim.regressors._styles import check_styles
from phonanim.regressors._torch_extra import require_torch

Self = TypeVar("Self", bound="AudioRegressor")


@dataclass(frozen=True)
class AudioRegressor(AudioModel):
    """An audio-driven model that can be trained and stored."""

    def tensors(self) -> Tensors:
        """The decoder's weights, the scaling and mixing of features, and the encoder's identity in bytes."""
        identity = np.frombuffer(self.identity.encode(), np.uint8)
        scaling: Tensors = {"centre": self.centre, "scale": self.scale, "mix": self.mix, "identity": identity}
        return scaling | {f"decoder_{name}": tensor for name, tensor in self.weights.items()}

    @classmethod
    def from_tensors(cls: type[Self], config: Any, tensors: Tensors) -> Self:
        """Raises ValueError when the size of a tensor does not match the configuration."""
        if not 0 <= config.style < config.styles:
            raise ValueError(f"there is no style {config.style} of {config.styles}")
        layers, dims = tensors["centre"].shape
        modes = len(tensors["decoder_output_bias"]) // (config.widths[1] if config.decoder == "mlp" else 1)
        shapes = {f"decoder_{n}": shape for n, shape in decoder_shapes(config, dims, modes).items()}
        shapes |= {"centre": (layers, dims), "scale": (layers, dims), "mix": (layers,)}
        real = fitting(tensors, shapes)
        weights = tensors_with_prefix(real, "decoder_")
        return cls(config, real["centre"], real["scale"], real["mix"], weights, identity_in(tensors))

    @classmethod
    def fit(
        cls: type[Self],
        config: Any,
        train: Examples,
        validation: Examples,
        rng: np.random.Generator,
        progress: Progress,
        journal: Path | None = None,
    ) -> Self:
        """Train on recordings; early stopping on `validation`.

        If `journal` is a folder, the state after each epoch is saved there, and an interrupted training is
        continued from it; loss.csv in it has the errors. Raises ModelError when the examples have no sounds,
        or a style that the configuration does not have.
        """
        require_torch()
        from phonanim.regressors._torch_audio import fit_audio

        check_sounds(train)
        check_styles(cls.__name__.lower(), config.styles, train, validation)
        return fit_audio(cls, config, train, validation, rng, progress, journal)
