"""Sensor positions over time, and sensor names."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from phonanim.core.lexicon import LEXICON
from phonanim.errors import CorpusError, OptionError

Array = NDArray[np.float64]
LETTERS = "xyz"
DIRECTIONS = {
    "forward": (0, 1.0), "back": (0, -1.0), "left": (1, 1.0), "right": (1, -1.0), "up": (2, 1.0),
    "down": (2, -1.0),
}  # fmt: skip
"""Possible directions of a file's axis: our axis, and its sign."""
OUR_AXES = "forward,left,up"


@dataclass(frozen=True)
class Articulation:
    """`positions` (samples, sensors, 3) mm at `start` + n / `rate` seconds; NaN where a sensor was lost.

    In measures, x is forward, y is to the speaker's left and z is up; `oriented` turns a file's axes into
    these. `source` is the file, for error messages.
    """

    names: tuple[str, ...]
    positions: Array
    rate: float
    start: float = 0.0
    source: str = ""

    @property
    def times(self) -> Array:
        """The instants of the samples, (samples,) seconds."""
        return self.start + np.arange(len(self.positions)) / self.rate

    def has(self, *sensors: str) -> bool:
        """Whether all of these sensors exist."""
        return all(self._place(sensor) is not None for sensor in sensors)

    def sensor(self, name: str) -> Array:
        """Positions of one sensor, (samples, 3) mm. Raises CorpusError when it does not exist.

        `name` is the name in the file, or the one of lexicon/sensors.csv (TT for the tongue tip).
        """
        place = self._place(name)
        if place is None:
            raise CorpusError(f"{self.source}: has no sensor {name}; it has {', '.join(self.names)}")
        return self.positions[:, place]

    def _place(self, name: str) -> int | None:
        if name in self.names:
            return self.names.index(name)
        known = [standard_name(own) for own in self.names]
        return known.index(name) if name in known else None


@cache
def _rows() -> list[dict[str, str]]:
    with (LEXICON / "sensors.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@cache
def _standard_names() -> dict[str, str]:
    return {
        alias.lower(): row["sensor"] for row in _rows() for alias in (row["sensor"], *row["also"].split())
    }


def sensor_label(name: str) -> str:
    """The standard name of a sensor with its meaning, for a legend: "t_tip" -> "TT, tongue tip"."""
    standard = standard_name(name)
    meanings = {row["sensor"]: row["meaning"] for row in _rows()}
    return f"{standard}, {meanings[standard]}" if standard in meanings else standard


def standard_name(name: str) -> str:
    """The name in lexicon/sensors.csv for a name in a file, or the name itself: "t_tip" -> "TT"."""
    return _standard_names().get(name.lower(), name)


def rename_sensors(articulation: Articulation, names: tuple[str, ...]) -> Articulation:
    """Rename sensors, in their order; "-" removes one. Raises OptionError."""
    if len(names) != len(articulation.names):
        raise OptionError(
            f"{len(names)} names for the {len(articulation.names)} sensors of {articulation.source}; "
            "give one for each, - for those to remove"
        )
    kept = [place for place, name in enumerate(names) if name != "-"]
    named = tuple(names[place] for place in kept)
    if twice := [name for name in named if named.count(name) > 1]:
        raise OptionError(f"{twice[0]} names two sensors of {articulation.source}; give each another name")
    return replace(articulation, names=named, positions=articulation.positions[:, kept])


def orient_axes(articulation: Articulation, axes: str) -> Articulation:
    """Turn a file's axes into forward, left and up; `axes` is the direction of its x, y, z: "left,back,up".

    Raises OptionError.
    """
    found = [DIRECTIONS.get(word.strip()) for word in axes.split(",")]
    known = [direction for direction in found if direction is not None]
    if sorted(axis for axis, _ in known) != [0, 1, 2] or len(found) != len(known):
        raise OptionError(f"{axes!r}: give the directions of x, y and z, as left,back,up or forward,left,up")
    turned = np.empty_like(articulation.positions)
    for own, (axis, sign) in enumerate(known):
        turned[..., axis] = sign * articulation.positions[..., own]
    return replace(articulation, positions=turned)
