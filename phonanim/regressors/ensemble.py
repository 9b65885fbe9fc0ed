"""A weighted mean of regressors: slow and good, the teacher from which one small network learns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from phonanim.regressors import InputModality
from phonanim.regressors._ensemble import MeanOfModels


@dataclass(frozen=True)
class Ensemble(MeanOfModels):
    """Phone-driven regressors and their weights."""

    input_modality: ClassVar[InputModality] = "phones"


REGRESSOR = Ensemble
