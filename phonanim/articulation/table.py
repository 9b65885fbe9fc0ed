"""The targets of lexicon/articulation.csv and the channels of lexicon/articulation_channels.csv."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.channels import CHANNELS
from phonanim.core.decode import DecodeError
from phonanim.core.lexicon import LEXICON
from phonanim.core.tables import parse_cell, read_records
from phonanim.errors import ModelError
from phonanim.speech.gestures import GESTURES

Array = NDArray[np.float64]

TARGETS_FILE = LEXICON / "articulation.csv"
CHANNELS_FILE = LEXICON / "articulation_channels.csv"


@dataclass(frozen=True)
class Targets:
    """The target of each gesture in each channel, and its weight.

    `target` (gestures, channels) mm and `weight` (gestures, channels), in the order of `GESTURES.names` and
    CHANNELS. A weight is resistance to neighbours: coarticulation depends on the ratio of weights. `sigma`
    (channels,) seconds is the spread of a gesture in time, `lead` (channels,) seconds is how much earlier
    a rounded gesture begins.
    """

    target: Array
    weight: Array
    sigma: Array
    lead: Array


@lru_cache(maxsize=8)
def read_targets(targets: Path = TARGETS_FILE, channels: Path = CHANNELS_FILE) -> Targets:
    """Read both tables. Raises ModelError that names the invalid or missing row."""
    shape = len(GESTURES.names), len(CHANNELS)
    target, weight = np.full(shape, np.nan), np.full(shape, np.nan)
    for number, row in _rows(targets):
        try:
            place = GESTURES.names.index(row["gesture"]), CHANNELS.index(row["channel"])
            target[place], weight[place] = (
                parse_cell(row["target"], "target"),
                parse_cell(row["weight"], "weight"),
            )
        except (KeyError, ValueError, TypeError) as error:
            raise ModelError(
                f"{targets} row {number}: needs a gesture, a channel, a target and a weight ({error})"
            ) from error
        if not weight[place] > 0 or not np.isfinite(target[place]):
            raise ModelError(f"{targets} row {number}: the target must be a number, the weight above 0")
    absent = np.argwhere(np.isnan(target))
    if len(absent):
        gesture, channel = GESTURES.names[absent[0, 0]], CHANNELS[absent[0, 1]]
        raise ModelError(f"{targets}: has no row for {gesture}, {channel}; add it")
    sigma, lead = _timing(channels)
    return Targets(target, weight, sigma, lead)


def _timing(path: Path) -> tuple[Array, Array]:
    found: dict[str, tuple[float, float]] = {}
    for number, row in _rows(path):
        try:
            found[row["channel"]] = parse_cell(row["sigma"], "sigma"), parse_cell(row["lead"], "lead")
        except (KeyError, ValueError, TypeError) as error:
            raise ModelError(f"{path} row {number}: needs a channel, a sigma and a lead ({error})") from error
        if not found[row["channel"]][0] > 0 or not found[row["channel"]][1] >= 0:
            raise ModelError(f"{path} row {number}: the sigma must be above 0 s, the lead not below")
    if absent := [name for name in CHANNELS if name not in found]:
        raise ModelError(f"{path}: has no row for {absent[0]}; add it")
    sigma, lead = np.array([found[name] for name in CHANNELS]).T
    return sigma, lead


def _rows(path: Path) -> list[tuple[int, dict[str, str]]]:
    try:
        return read_records(path)
    except (OSError, DecodeError) as error:
        raise ModelError(f"{path}: cannot be read: {error}") from error
