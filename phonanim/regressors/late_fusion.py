"""Sound and phones, each by its own model: the weighted mean of models that hear and models that read.

What one network learns from both at once is in hybrid.py; here neither knows of the other, so that none can
lean on what the other would have told.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from phonanim.regressors import InputModality
from phonanim.regressors._ensemble import MeanOfModels


@dataclass(frozen=True)
class LateFusion(MeanOfModels):
    """An ensemble (its `members` are the same tables) that is given the recording as well."""

    input_modality: ClassVar[InputModality] = "both"


REGRESSOR = LateFusion
