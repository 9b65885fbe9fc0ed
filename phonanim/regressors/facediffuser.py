"""FaceDiffuser (Stan 2023), reimplemented from the thesis: motion that is sampled from noise and sound.

A recurrent network learns to estimate motion from motion with noise, given the sound. Repeated from pure
noise on, it gives a different animation of a line for each seed. The thesis trains on vertices of a mesh
("V") and on controls of a rig ("B"). Here the targets of `fit` may be either: modes of the face, as for every
regressor, or any other curves (benchmarks/facediffuser.py trains it on ARKit's controls).

Differences: by default the encoder of the sound is not trained further (`tuned`), and its features are
averaged at the model's steps (`pairs`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.neural import tensors_with_prefix
from phonanim.regressors import Examples, Progress, Tensors
from phonanim.regressors._audio_input import check_sounds, fitting, identity_in
from phonanim.regressors._denoiser import Denoiser
from phonanim.regressors._diffusion import weight_shapes
from phonanim.regressors._styles import check_styles
from phonanim.regressors._torch_extra import require_torch

Array = NDArray[np.float64]
Floats = NDArray[np.float32]


@dataclass(frozen=True)
class FaceDiffuser(Denoiser):
    """A denoiser that can be trained and stored."""

    def tensors(self) -> Tensors:
        """The network's weights, the scaling of features and targets, and the encoder's identity in bytes."""
        identity = np.frombuffer(self.identity.encode(), np.uint8)
        scaling = {name: getattr(self, name) for name in ("centre", "scale", "low", "span")}
        return scaling | {f"network_{n}": t for n, t in self.weights.items()} | {"identity": identity}

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> FaceDiffuser:
        """Raises ValueError when the size of a tensor does not match the configuration."""
        dims, modes = tensors["centre"].shape[1], len(tensors["low"])
        known = weight_shapes(config, dims, modes, "network_tuned_norm" in tensors)
        shapes = {f"network_{name}": shape for name, shape in known.items()}
        shapes |= {"centre": (1, dims), "scale": (1, dims), "low": (modes,), "span": (modes,)}
        real = fitting(tensors, shapes)
        scaling = {name: real[name] for name in ("centre", "scale", "low", "span")}
        weights, identity = tensors_with_prefix(real, "network_"), identity_in(tensors)
        return cls(config=config, weights=weights, identity=identity, **scaling)

    @classmethod
    def fit(
        cls,
        config: Any,
        train: Examples,
        validation: Examples,
        rng: np.random.Generator,
        progress: Progress,
        journal: Path | None = None,
    ) -> FaceDiffuser:
        """Train on recordings; the state with the least error of a quick sample of `validation` is kept.

        If `journal` is a folder, the state after each epoch is saved there, and an interrupted training is
        continued from it; loss.csv in it has the errors. Raises ModelError when the examples have no sounds,
        or a style that the configuration does not have.
        """
        require_torch()
        from phonanim.regressors._torch_diffusion import fit_diffusion

        check_sounds(train)
        check_styles("facediffuser", config.styles, train, validation)
        return fit_diffusion(cls, config, train, validation, rng, progress, journal)


REGRESSOR = FaceDiffuser
