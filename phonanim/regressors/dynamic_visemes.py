"""Dynamic visemes: concatenate recorded movements of the mouth (Taylor et al. 2012).

The recordings are cut into gestures at minima of the mouth's speed, similar gestures are clustered, and each
cluster becomes one unit: a movement with a duration and a distribution of phones. A track is covered with
units by dynamic programming. The cost of a unit combines its phones, its joins and its speaking rate:

    sum over units  d * mean_k( -ln P_k(phone at place k | unit) )      phones, d in steps of time
                    + join * |end of the unit before - start|^2 / variance
                    + rate * ln(d / usual duration of the unit)^2

Units are stretched to their time, and the gap at a join is spread over the units on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.features.windows import TICK
from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.regressors._dynamic_visemes_config import PLACES, Config
from phonanim.regressors._styles import OffsetStyles, offset_tensors, read_offsets, split_offsets
from phonanim.speech.inventory import N_PHONES
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
TABLES = ("paths", "phones", "durations", "joins")


@dataclass(frozen=True)
class Units(OffsetStyles):
    """The units: `paths` (units, points, modes) from start to end, `durations` (units,) in seconds,
    `phones` (places, 41, units) the ln P_k(phone | unit), and `joins` (units, units) the distances from
    the end of one to the start of another.
    """

    config: Config
    paths: NDArray[np.float32]
    phones: NDArray[np.float32]
    durations: NDArray[np.float32]
    joins: NDArray[np.float32]
    offsets: NDArray[np.float32] | None = None

    input_modality: ClassVar[InputModality] = "phones"
    config_class: ClassVar[type] = Config

    def predict(self, track: PhoneTrack, times: Array, sound: Sound | None = None) -> NDArray[np.float32]:
        """Modes at instants, (times,) seconds -> (times, modes); linear between the points of units."""
        units, bounds = self.select(track)
        found = play_units(self.paths[units], bounds, np.clip(times, 0, bounds[-1]))
        return self.in_style(found, self.offsets)

    def select(self, track: PhoneTrack) -> tuple[NDArray[np.int64], Array]:
        """The cheapest units that cover a track, (chosen,), and their bounds in seconds, one more."""
        steps = max(1, int(np.ceil(track.duration / self.config.step - TICK)))
        lengths = np.arange(1, max(1, round(self.config.longest / self.config.step)) + 1)
        rates = (
            self.config.rate * np.log(lengths[:, None] * np.float32(self.config.step) / self.durations) ** 2
        )
        cost = np.full(
            (steps + len(lengths) + 1, len(self.paths)), np.inf, np.float32
        )  # least cost of a cover that ends there
        length = np.zeros(cost.shape, np.int16)
        before = np.zeros(cost.shape, np.int32)
        cost[0] = 0
        joins = self.config.join * self.joins.T
        for step in range(steps):
            joined = cost[step] + joins if step else 0 * joins
            before[step] = joined.argmin(axis=1)
            start = joined[np.arange(len(joined)), before[step]]
            ahead = start + self._against(track, step, lengths) + rates
            there = slice(step + 1, step + 1 + len(lengths))
            better = ahead < cost[there]
            cost[there] = np.where(better, ahead, cost[there])
            length[there] = np.where(better, lengths[:, None], length[there])
        return self._trace(cost[steps], length, before, steps)

    def _against(self, track: PhoneTrack, step: int, lengths: NDArray[np.int64]) -> Array:
        """The phone cost of each unit from a step on, for (lengths,) steps -> (lengths, units)."""
        places = (step + lengths[:, None] * PLACES) * self.config.step
        codes = track.sample(places.ravel() + TICK).reshape(places.shape)
        scores = self.phones[np.arange(len(PLACES)), codes].mean(axis=1)
        return np.asarray(-lengths[:, None] * scores, np.float32)

    def _trace(
        self, last: Array, length: NDArray[np.int16], before: NDArray[np.int32], steps: int
    ) -> tuple[NDArray[np.int64], Array]:
        unit, at = int(last.argmin()), steps
        units, ends = [], [steps]
        while at > 0:
            units.append(unit)
            at -= int(length[at, unit])
            ends.append(at)
            unit = int(before[at, unit])
        return np.array(units[::-1]), np.array(ends[::-1]) * self.config.step

    def tensors(self) -> Tensors:
        """The tables of the units, and the offsets of styles, by name."""
        return {name: getattr(self, name) for name in TABLES} | offset_tensors(self.offsets)

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> Units:
        """Raises ValueError when the tables are not for the same units."""
        count = len(tensors["paths"])
        wanted = {"phones": (len(PLACES), N_PHONES, count), "durations": (count,), "joins": (count, count)}
        for name, shape in wanted.items():
            if tensors[name].shape != shape:
                raise ValueError(f"{name} is {tensors[name].shape}, not {shape}")
        offsets = read_offsets(config.styles, tensors["paths"].shape[2], tensors)
        return cls(config, **{name: tensors[name].astype(np.float32) for name in TABLES}, offsets=offsets)

    @classmethod
    def fit(
        cls, config: Any, train: Examples, validation: Examples, rng: np.random.Generator, progress: Progress
    ) -> Units:
        """Cut, cluster and count; `validation` is not needed.

        Raises ModelError for a style beyond `styles`.
        """
        from phonanim.regressors._gestures import fit_units

        train, offsets = split_offsets("dynamic_visemes", config.styles, train)
        return cls(config, **fit_units(config, train, rng, progress), offsets=offsets)


def play_units(paths: NDArray[np.floating], bounds: Array, times: Array) -> NDArray[np.float32]:
    """Units one after the other, (units, points, modes) from bounds[i] to bounds[i + 1] s -> (times, modes).

    Neighbours meet halfway between the end of one and the start of the other; each unit is moved there by
    adding a linear function of time.
    """
    paths = paths.astype(np.float64)
    meeting = (paths[:-1, -1] + paths[1:, 0]) / 2
    at_start = np.concatenate([paths[:1, 0], meeting]) - paths[:, 0]
    at_end = np.concatenate([meeting, paths[-1:, -1]]) - paths[:, -1]
    ramp = np.linspace(0, 1, paths.shape[1])[:, None]
    paths = paths + (1 - ramp) * at_start[:, None] + ramp * at_end[:, None]
    unit = np.clip(np.searchsorted(bounds, times, side="right") - 1, 0, len(paths) - 1)
    place = (times - bounds[unit]) / (bounds[unit + 1] - bounds[unit]) * (paths.shape[1] - 1)
    point = np.clip(place.astype(np.int64), 0, paths.shape[1] - 2)
    lower, upper = paths[unit, point], paths[unit, point + 1]
    return np.asarray(lower + (upper - lower) * (place - point)[:, None], np.float32)


REGRESSOR = Units
