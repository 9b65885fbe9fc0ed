"""The least and the most of the settings of the regressors of this package, by name."""

from __future__ import annotations

from typing import Any

from phonanim.errors import ModelError

SIZES = (
    *("networks", "reach", "width", "widths", "window", "states", "depth", "heads", "kernels", "dilations"),
    *("channels", "hidden", "units", "latent", "trees", "styles"),
)
"""Settings that say how much a model computes; none is below 1."""

MAX_SIZE, MAX_NUMBER = 4096, 1e9
"""Largest of these settings, and of all others."""

COUNTS = ("batch", "leaf", "timesteps", "steps", "clusters", "alignments")
"""Other whole numbers from 1 on."""

ABOVE_ZERO = ("rate", "delta", "smoothing", "shortest", "longest", "step", "doubt")
"""Numbers above 0, such as rates in hertz and lengths in seconds."""

LEAST = 1e-9
"""The least number above 0."""

SHARES = {"dropout": (0.0, 0.99), "masked": (0.0, 1.0), "columns": (LEAST, 1.0)}
CHECKED_LATER = ("ahead", "seed", "tuned")
"""What the kinds themselves check, against their other settings."""


def check_range(key: str, value: Any, where: str, own: bool) -> None:
    """Raise ModelError for a number, or a list of numbers, that a setting cannot have.

    Regressors from outside the package (not `own`) give their settings their own meaning, so that only the
    largest numbers are checked.
    """
    least, most = _limits(key) if own else (-MAX_NUMBER, _most(key))
    for item in value if isinstance(value, (list, tuple)) else [value]:
        if not isinstance(item, (int, float)) or least <= item <= most:  # NaN is in no range
            continue
        if not abs(item) <= _most(key):
            raise ModelError(f"{where}: {key} is {value!r:.40}; the most is {_most(key):g}")
        asked = "a number above 0" if least == LEAST else f"{least:g} or more"
        asked += f", at most {most:g}" if key in SHARES else ""
        raise ModelError(f"{where}: {key} is {value!r:.40}; take {asked}")


def _most(key: str) -> float:
    return MAX_SIZE if key in (*SIZES, "ahead") else MAX_NUMBER


def _limits(key: str) -> tuple[float, float]:
    if key in SHARES:
        return SHARES[key]
    if key in SIZES or key in COUNTS:
        return 1, _most(key)
    if key in ABOVE_ZERO:
        return LEAST, MAX_NUMBER
    return (-_most(key) if key in CHECKED_LATER else 0), _most(key)
