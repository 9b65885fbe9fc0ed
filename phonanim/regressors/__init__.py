"""Regressors: phones (or audio) in, modes of the reference face out. One file each; its stem is its kind.

Models of other targets (phonanim/targets) learn rows of numbers of those in place of modes.
"""

from phonanim.inputs.speech_input import InputModality
from phonanim.regressors._files import RECOGNITION, load, load_face, save, save_face
from phonanim.regressors._kinds import (
    REGRESSORS,
    kind_of,
    kinds,
    make_config,
    regressor_class,
)
from phonanim.regressors._model import Model, in_style
from phonanim.regressors._protocol import CHECKPOINT, NEEDS, Examples, Progress, Regressor, Tensors

__all__ = [
    "CHECKPOINT",
    "NEEDS",
    "RECOGNITION",
    "REGRESSORS",
    "Examples",
    "InputModality",
    "Model",
    "Progress",
    "Regressor",
    "Tensors",
    "in_style",
    "kind_of",
    "kinds",
    "load",
    "load_face",
    "make_config",
    "regressor_class",
    "save",
    "save_face",
]
