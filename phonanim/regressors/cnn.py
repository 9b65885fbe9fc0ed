"""The streaming convolutional network (Medina 2023, section 5.4, Table 5.3), reimplemented from the thesis.

Kernels of 15, 7 and 3 steps of 20 ms. The thesis centres all three and counts half of the first one as the
latency, 8 steps. An exact prediction of a step would need all three halves, 11 steps. Here the first kernel
is centred and the others end at the predicted step, so that 7 steps of look-ahead are enough.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from phonanim.regressors._audio_config import Decoder, Settings
from phonanim.regressors._streaming import Streamed


@dataclass(frozen=True)
class Config(Settings):
    """Kernels as published; `ctc` = 0.004 is the best of Table 5.4. The thesis does not give the channels."""

    encoder: str = "mfcc_live"
    decoder: Decoder = "convolution"
    kernels: tuple[int, ...] = (15, 7, 3)
    dilations: tuple[int, ...] = (1, 1, 1)
    channels: tuple[int, ...] = (128, 128, 128)
    ahead: int = 7
    window: int = 150


@dataclass(frozen=True)
class CNN(Streamed):
    """A trained model."""

    config_class: ClassVar[type] = Config


REGRESSOR = CNN
