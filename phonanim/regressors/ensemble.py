"""A weighted mean of regressors: slow and accurate; the teacher of a single small network."""

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
