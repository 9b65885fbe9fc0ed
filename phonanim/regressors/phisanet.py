"""PhISANet (Medina 2023, chapter 4), reimplemented from the thesis: modes, with phones as an auxiliary task.

All layers of a speech encoder with learned weights (section 4.5), a bidirectional GRU, a loss on velocity and
acceleration (4.4), and the phone sequence as an auxiliary task (4.6). Targets here are modes of the face, not
rig controls; the rig follows later (phonanim/rig). Layers are normalized before they are mixed, which the
thesis does not mention.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from phonanim.regressors._audio import AudioRegressor
from phonanim.regressors._audio_config import Settings


@dataclass(frozen=True)
class Config(Settings):
    """The published values: section 4.7, Table 4.4 for Whisper, Table 4.5."""

    inputs: Literal["enc", "all_enc"] = "all_enc"
    hidden: int = 1024
    depth: int = 5
    velocity: float = 0.5
    acceleration: float = 0.2
    ctc: float = 0.008
    normalize: Literal["minmax", "scale"] = "minmax"
    optimizer: Literal["adam", "radam"] = "radam"
    epochs: int = 200


@dataclass(frozen=True)
class PhISANet(AudioRegressor):
    """A trained model."""

    config_class: ClassVar[type] = Config


REGRESSOR = PhISANet
