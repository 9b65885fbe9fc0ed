"""Late fusion: the weighted mean of audio-driven and phone-driven models, trained separately.

In hybrid.py, one network learns from both inputs at once. Here the models are independent, so that none can
rely on the input of the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from phonanim.regressors import InputModality
from phonanim.regressors._ensemble import MeanOfModels


@dataclass(frozen=True)
class LateFusion(MeanOfModels):
    """An ensemble (its `members` are the same tables) that also gets the recording."""

    input_modality: ClassVar[InputModality] = "both"


REGRESSOR = LateFusion
