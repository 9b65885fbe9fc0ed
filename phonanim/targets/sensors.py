"""Sensors of articulography: a row has their coordinates, scaled; predictions become articulation in mm."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import CorpusError
from phonanim.targets import Array, Clip, Floats, Source, TargetSettings
from phonanim.targets._moments import moments_of

AXES = 3  # forward, left, up


@dataclass(frozen=True, eq=False)
class Sensors:
    """Sensors `names` (sensors,) that are called as in lexicon/sensors.csv, in mm forward, left and up.

    A row has (value - `low`) / `span` of the coordinates in `moving` (3 sensors,), where a value is the
    distance from the subject's mean position, `rest` (sensors, 3); without one, that of the training subjects
    is meant. `zeros` are what is added to the channels of articulation that sensors show, mm: each sensor has
    its own zero.
    """

    data: str
    names: tuple[str, ...]
    moving: NDArray[np.bool_]
    low: Floats
    span: Floats
    rest: Floats
    zeros: Mapping[str, float] = field(default_factory=dict)

    kind: ClassVar[str] = "sensors"

    @property
    def size(self) -> int:
        """Coordinates that move."""
        return int(self.moving.sum())

    def encode(self, frames: NDArray[np.floating], rest: Array | None = None) -> Floats:
        """Rows, (frames, sensors, 3) mm -> (frames, size)."""
        flat = (frames - (self.rest if rest is None else rest)).reshape(len(frames), -1)
        return np.asarray(((flat - self.low) / self.span)[:, self.moving], np.float32)

    def decode(self, rows: NDArray[np.floating], rest: Array | None = None) -> Floats:
        """Sensors, (frames, size) -> (frames, sensors, 3) mm."""
        values = np.tile(self.low, (len(rows), 1))
        values[:, self.moving] += rows * self.span[self.moving]
        moved = values.reshape(len(rows), -1, AXES) + (self.rest if rest is None else rest)
        return np.asarray(moved, np.float32)

    def channels(self, frames: NDArray[np.floating]) -> dict[str, Array]:
        """The channels of articulation that sensors show, (frames, sensors, 3) -> (frames,) mm each."""
        found = mouth_channels(frames, self.names)
        return {name: curve + self.zeros.get(name, 0.0) for name, curve in found.items()}

    @classmethod
    def fit(cls, settings: TargetSettings, source: Source, clips: Iterable[Clip]) -> Sensors:
        """Learn ranges or moments. Raises CorpusError when nothing moves, or sensors have no names."""
        if not source.names:
            raise CorpusError(f"{source.data}: its sensors have no names; build the corpus with names")
        rests: list[Array] = []
        found = moments_of(_from_rest(clips, rests), source.data)
        low, span = found.scaling(settings)
        parts = (
            np.where(found.moving, low, found.mean),
            np.where(found.moving, span, 1.0),
            np.mean(rests, axis=0),
        )
        low, span, rest = (part.astype(np.float32) for part in parts)
        return cls(source.data, source.names, found.moving, low, span, rest)

    def tensors(self) -> dict[str, NDArray[Any]]:
        """The scaling."""
        moving = self.moving.astype(np.uint8)
        return {"moving": moving, "low": self.low, "span": self.span, "rest": self.rest.ravel()}

    def facts(self) -> dict[str, Any]:
        """The names of the sensors, the data set, and the zeros of the channels."""
        return {"data": self.data, "names": list(self.names), "zeros": dict(self.zeros)}

    @classmethod
    def from_parts(cls, facts: Mapping[str, Any], tensors: Mapping[str, NDArray[Any]]) -> Sensors:
        """Raises KeyError or ValueError when the parts do not match."""
        names = tuple(map(str, facts["names"]))
        if any(tensor.shape != (AXES * len(names),) for tensor in tensors.values()):
            raise ValueError(f"its tensors are not of {len(names)} sensors")
        low, span, rest = (tensors[name].astype(np.float32) for name in ("low", "span", "rest"))
        zeros = {str(name): float(value) for name, value in facts["zeros"].items()}
        return cls(
            str(facts["data"]),
            names,
            tensors["moving"].astype(bool),
            low,
            span,
            rest.reshape(-1, AXES),
            zeros,
        )


def _from_rest(clips: Iterable[Clip], rests: list[Array]) -> Iterator[Clip]:
    """Frames as distances from the mean position of their subject, which is added to `rests`."""
    for frames, rest in clips:
        values = np.asarray(frames, np.float64)
        rests.append(values.mean(axis=0) if rest is None else rest)
        yield values - rests[-1], None


def mouth_channels(frames: NDArray[np.floating], names: tuple[str, ...]) -> dict[str, Array]:
    """The channels of articulation of sensors, (frames, sensors, 3) mm forward, left, up -> (frames,) each.

    The jaw is the sensor on the lower incisors. Lip gap and protrusion come from the sensors on both lips.
    The width is twice the distance of the mouth corner from the middle. The tongue's body is its dorsum. Each
    curve has the zero of its sensors.
    """
    place = {name: np.asarray(frames[:, row], np.float64) for row, name in enumerate(names)}
    found: dict[str, Array] = {}
    if "UL" in place and "LL" in place:
        upper, lower = place["UL"], place["LL"]
        found["lip_gap"] = upper[:, 2] - lower[:, 2]
        found["protrusion"] = (upper[:, 0] + lower[:, 0]) / 2
        found["upper_lip"] = upper[:, 2]
    if "LI" in place:
        found["jaw"] = -place["LI"][:, 2]
    if "LC" in place:
        found["lip_width"] = 2 * np.abs(place["LC"][:, 1])
    for sensor, channel in (("TT", "tongue_tip"), ("TD", "tongue_body")):
        if sensor in place:
            found |= {f"{channel}_height": place[sensor][:, 2], f"{channel}_front": place[sensor][:, 0]}
    return found


TARGET = Sensors
