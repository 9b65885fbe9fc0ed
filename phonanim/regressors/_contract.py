"""Whether a class keeps the contract of `phonanim.regressors.Regressor`; where not, one line says why."""

from __future__ import annotations

from dataclasses import MISSING, fields
from inspect import signature
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import ModelError

METHODS = {
    "fit": ("config", "train", "validation", "rng", "progress"),
    "predict": ("self", "track", "times"),
    "tensors": ("self",),
    "from_tensors": ("config", "tensors"),
}
"""Each method with the arguments that it is called with; `fit` and `from_tensors` are class methods."""
MODALITIES = ("phones", "audio", "both")
MEND = "docs/extending.md shows a whole one"
TRIED = 50  # instants that a trained regressor is tried out with


def check_class(part: Any, kind: str) -> None:
    """Raise ModelError when a module's REGRESSOR is no class of the contract. `kind` is its name."""
    found = getattr(part, "REGRESSOR", None)
    if not isinstance(found, type):
        raise ModelError(
            f"regressor {kind!r} ({part.__name__}): has no class REGRESSOR; "
            f"end it with REGRESSOR = YourClass; {MEND}"
        )
    where = f"regressor {kind!r} ({found.__module__}.{found.__name__})"
    lacking = [name for name in METHODS if not callable(getattr(found, name, None))]
    if lacking:
        raise ModelError(f"{where}: has no {' and no '.join(lacking)}; {MEND}")
    for name, arguments in METHODS.items():
        try:
            signature(getattr(found, name)).bind(*arguments)
        except TypeError as error:
            kind_of_method = "class method" if arguments[0] == "config" else "method"
            raise ModelError(
                f"{where}: {name} is not a {kind_of_method} of ({', '.join(arguments)}): {error}; {MEND}"
            ) from error
    modality = getattr(found, "input_modality", None)
    if modality not in MODALITIES:
        raise ModelError(f"{where}: input_modality is {modality!r}; set {', '.join(MODALITIES)}")
    config = getattr(found, "config_class", None)
    parameters = getattr(config, "__dataclass_params__", None)
    if not isinstance(config, type) or not getattr(parameters, "frozen", False):
        raise ModelError(f"{where}: config_class is not a frozen dataclass; {MEND}")


def check_required(config: Any, values: dict[str, Any], where: str) -> None:
    """Raise ModelError for a setting without a default that a table of values lacks."""
    for field in fields(config):
        required = field.default is MISSING and field.default_factory is MISSING
        if required and field.name not in values:
            raise ModelError(f"{where}: lacks the setting {field.name!r}; give it under [settings]")


def check_fitted(regressor: Any, kind: str, track: Any, times: NDArray[np.float64], modes: int) -> None:
    """Raise ModelError when a trained regressor of phones does not keep the contract of its methods.

    It is asked for modes at no instant, at the first of `times` (frames,) of a track and beyond both ends,
    stored, and asked again.
    """
    where = f"regressor {kind!r}"
    times = np.concatenate([[-1.0], times[:TRIED], [track.duration + 1.0]])
    if not hasattr(regressor, "predict") or not hasattr(regressor, "config"):
        raise ModelError(
            f"{where}: fit returns {type(regressor).__name__}, no regressor with its config; {MEND}"
        )
    _predicted(regressor, where, track, times[:0], modes)
    first = _predicted(regressor, where, track, times, modes)
    tensors = regressor.tensors()
    if not isinstance(tensors, dict) or not all(_can_be_stored(part) for part in tensors.values()):
        raise ModelError(
            f"{where}: tensors() is not a dict of NumPy arrays of numbers by name; return one, {{}} at least"
        )
    try:
        again = type(regressor).from_tensors(regressor.config, tensors)
    except (KeyError, ValueError) as error:
        raise ModelError(f"{where}: from_tensors does not read what tensors() gave: {error!r}") from error
    if not np.array_equal(first, _predicted(again, where, track, times, modes)):
        raise ModelError(
            f"{where}: predicts otherwise after tensors() and from_tensors(); store all that was learned"
        )


def _can_be_stored(part: Any) -> bool:
    return isinstance(part, np.ndarray) and part.dtype.kind in "biuf"


def _predicted(regressor: Any, where: str, track: Any, times: NDArray[np.float64], modes: int) -> Any:
    try:
        found = regressor.predict(track, times)
    except (ArithmeticError, AssertionError, LookupError, TypeError, ValueError) as error:
        raise ModelError(
            f"{where}: predict fails at {len(times)} instants, some of them beyond both ends: {error!r}"
            if len(times)
            else f"{where}: predict fails at no instant at all: {error!r}; give shape (0, {modes})"
        ) from error
    wanted = (len(times), modes)
    if not isinstance(found, np.ndarray) or found.shape != wanted or found.dtype != np.float32:
        told = (
            f"{found.dtype} of shape {found.shape}" if isinstance(found, np.ndarray) else type(found).__name__
        )
        raise ModelError(
            f"{where}: predict gives {told} at {len(times)} instants; give float32 of shape {wanted}"
        )
    if not np.isfinite(found).all():
        raise ModelError(f"{where}: predict gives numbers that are not finite; correct it or its training")
    return found
