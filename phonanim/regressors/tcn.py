"""The temporal convolutional network (Lea et al. 2016; Medina 2023, section 5.4, Table 5.2), reimplemented.

Each layer has two convolutions of 2 steps, and the distance of the steps doubles from layer to layer: three
layers cover 15 steps (eq. 5.2), all in the past. `ahead` shifts the covered steps into the future.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from phonanim.regressors._audio_config import Decoder, Settings
from phonanim.regressors._streaming import Streamed


@dataclass(frozen=True)
class Config(Settings):
    """The three layers of Table 5.2, the choice of the thesis."""

    encoder: str = "mfcc_live"
    decoder: Decoder = "convolution"
    kernels: tuple[int, ...] = (2, 2, 2, 2, 2, 2)
    dilations: tuple[int, ...] = (1, 1, 2, 2, 4, 4)
    channels: tuple[int, ...] = (512, 512, 256, 256, 128, 128)
    ahead: int = 0
    window: int = 150


@dataclass(frozen=True)
class TCN(Streamed):
    """A trained model."""

    config_class: ClassVar[type] = Config


REGRESSOR = TCN
