"""Speech to landmarks in two stages (Medina 2023, chapter 3), reimplemented from the thesis.

An encoder and one of several decoders predict landmarks by their squared error; the rig is solved afterwards
(`--retarget solve`). Landmarks here are those of the face model, represented by its modes: as the modes are
orthonormal, their squared error is that of the landmarks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from phonanim.regressors._audio import AudioRegressor
from phonanim.regressors._audio_config import Settings


@dataclass(frozen=True)
class Config(Settings):
    """The values of section 3.2.2, for windows of 300 ms; `hidden` is its MLP's."""

    hidden: int = 512
    depth: int = 5
    window: int = 15
    dropout: float = 0.25
    learning_rate: float = 1e-5


@dataclass(frozen=True)
class TwoStage(AudioRegressor):
    """A trained model."""

    config_class: ClassVar[type] = Config


REGRESSOR = TwoStage
