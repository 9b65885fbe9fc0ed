"""Style dials: more or less motion of the whole face, of the jaw, of the lips."""

from __future__ import annotations

import re
from collections.abc import Mapping
from difflib import get_close_matches

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import OptionError
from phonanim.options import DEFAULTS, Options
from phonanim.rig import Rig

# mouthClose undoes jawOpen at the lips, so it belongs to the jaw: scaled alike, closed lips stay closed.
JAW = re.compile(r"jaw|mouthClose|lips_?together", re.IGNORECASE)
LIPS = re.compile(r"mouth|lip", re.IGNORECASE)
# Options that scale or add.
BLENDING = (
    *("intensity", "jaw", "lips", "gains", "smooth", "overlays"),
    *("blinks", "life", "life_seed", "look_at", "emotions"),
)


def scale_controls(
    values: NDArray[np.float32],
    rig: Rig,
    intensity: float = 1.0,
    jaw: float = 1.0,
    lips: float = 1.0,
    own: Mapping[str, float] | None = None,
) -> NDArray[np.float32]:
    """Scale the distance of each control from rest, (frames, controls); 1 changes nothing, 0 holds still.

    `jaw` and `lips` scale the controls that are named after them, `intensity` all, `own` single ones; limits
    are kept. Gains do not apply to stepped (2D) rigs. A share of another control (MetaHuman's Lips Together)
    uses only its own gain. Raises OptionError when the rig lacks a control of `own`.
    """
    own = own or {}
    _check(own, rig)
    if is_stepped_rig(rig):
        return values
    gains = intensity * np.array([_gain(name, jaw, lips) for name in rig.controls])
    if rig.through is not None:
        gains[[share for share, _, _ in rig.through.shares]] = 1.0
    gains *= _singles(own, rig)
    if np.all(gains == 1.0):
        return values
    scaled = rig.rest + gains * (values - rig.rest)
    scaled = np.clip(scaled, rig.minimum, rig.maximum)
    for low, high in rig.at_most:
        scaled[:, low] = np.minimum(scaled[:, low], scaled[:, high])
    return scaled.astype(np.float32)


def is_stepped_rig(rig: Rig) -> bool:
    """Whether a rig shows one mouth at a time, to which gains do not apply."""
    return rig.visemes is not None and rig.visemes.stepped


def unused_option_warnings(options: Options, rig: Rig) -> tuple[str, ...]:
    """A note on the options that have no effect on a stepped rig, or none."""
    given = [name for name in BLENDING if getattr(options, name) != getattr(DEFAULTS, name)]
    if not given or not is_stepped_rig(rig):
        return ()
    return (f"{rig.name} shows one mouth at a time, so {', '.join(given)} did nothing; choose another --rig",)


def _check(own: Mapping[str, float], rig: Rig) -> None:
    for name in own:
        if name not in rig.controls:
            near = get_close_matches(name, rig.controls, n=1)
            hint = f"; did you mean {near[0]}?" if near else "; `phonanim rig list` names the rigs"
            raise OptionError(f"gain {name}={own[name]:g}: {rig.name} has no such control{hint}")


def _singles(own: Mapping[str, float], rig: Rig) -> NDArray[np.float64]:
    """The gain of every control, in the order of the rig.

    A control that may not exceed another (mouthClose and jawOpen) takes the other's gain unless it has its
    own. Otherwise closed lips would part.
    """
    gains = np.array([own.get(name, 1.0) for name in rig.controls])
    for low, high in rig.at_most:
        gains[low] = own.get(rig.controls[low], gains[high])
    return gains


def _gain(control: str, jaw: float, lips: float) -> float:
    if JAW.search(control):
        return jaw
    return lips if LIPS.search(control) else 1.0
