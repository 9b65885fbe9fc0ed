"""Phones and pairs of phones as examples of sensor motion, and the statistics of each kind."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.ema.articulation import LETTERS, Articulation, standard_name
from phonanim.ema.measures import speeds, tongue_curvature, tongue_width
from phonanim.evaluation.statistics import pearson_sums
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
MIDSAGITTAL, SIDES = ("TD", "TB", "TT"), ("BL", "BR")
SILENT = {0} | {code for code, sound in enumerate(INVENTORY.sounds) if sound.kind == "silence"}


@dataclass(frozen=True)
class Stretch:
    """A phone or a pair of phones from `start` to `end` in seconds.

    `kind` is V or C for a vowel or a consonant, VC, CV, VV or CC for a pair.
    """

    name: str
    kind: str
    start: float
    end: float


@dataclass(frozen=True)
class Row:
    """Statistics of one name: the number of examples, and the mean and standard deviation of each measure.

    A measure without examples is NaN; the deviation of a single example is NaN.
    """

    name: str
    kind: str
    examples: int
    means: dict[str, float]
    deviations: dict[str, float]


def phone_stretches(track: PhoneTrack) -> list[Stretch]:
    """Every phone except silence."""
    found = zip(track.codes.tolist(), track.bounds[:-1], track.bounds[1:], strict=True)
    return [Stretch(_name(c), _kind(c), float(a), float(b)) for c, a, b in found if c not in SILENT]


def diphone_stretches(track: PhoneTrack) -> list[Stretch]:
    """Every pair of phones without silence, from the middle of the first to that of the second.

    Pairs at the edge of speech are left out, as in Medina 2023, section 2.2.
    """
    middles = (track.bounds[:-1] + track.bounds[1:]) / 2
    pairs = zip(track.codes.tolist(), track.codes[1:].tolist(), middles, middles[1:], strict=False)
    return [
        Stretch(f"{_name(a)} {_name(b)}", _kind(a) + _kind(b), float(start), float(end))
        for a, b, start, end in pairs
        if not {a, b} & SILENT
    ]


def _name(code: int) -> str:
    return INVENTORY.phones[code]


def _kind(code: int) -> str:
    return "V" if INVENTORY.sounds[code].kind == "vowel" else "C"


def measured_curves(articulation: Articulation) -> dict[str, Array]:
    """Measured curves, (samples,) each: speeds, and the tongue's shape if there are sensors for it.

    `speed_<sensor>` is in mm/s, `width` in mm, `curvature` in 1/mm.
    """
    names = [standard_name(name) for name in articulation.names]
    found = {f"speed_{name}": curve for name, curve in zip(names, speeds(articulation).T, strict=True)}
    if articulation.has(*SIDES):
        found["width"] = tongue_width(articulation)
    if articulation.has("TB", *SIDES):
        found["curvature"] = tongue_curvature(articulation)
    return found


def measure_stretch(
    stretch: Stretch, found: dict[str, Array], articulation: Articulation
) -> dict[str, float]:
    """Peaks of speeds and means of shapes in a stretch; NaN if a sensor was lost in it.

    Source: Medina 2023, sections 2.2.2 and 2.2.3.
    """
    inside = slice(*np.searchsorted(articulation.times, (stretch.start, stretch.end)))
    values = {name: curve[inside] for name, curve in found.items()}
    return {
        name: float(part.max() if name.startswith("speed") else part.mean()) if len(part) else np.nan
        for name, part in values.items()
    }


def side_sums(stretch: Stretch, articulation: Articulation) -> dict[tuple[str, str, str], Array]:
    """Sums for Pearson's r of each midsagittal tongue sensor with each lateral one, by axis, (6,) each.

    Source: Medina 2023, section 2.2.1. Empty without lateral sensors.
    """
    inside = slice(*np.searchsorted(articulation.times, (stretch.start, stretch.end)))
    found = {}
    for middle in filter(articulation.has, MIDSAGITTAL):
        for side in filter(articulation.has, SIDES):
            a, b = articulation.sensor(middle)[inside], articulation.sensor(side)[inside]
            both = np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1)
            for axis, letter in enumerate(LETTERS):
                found[middle, side, letter] = pearson_sums(a[both, axis], b[both, axis])
    return found


def summarize_examples(examples: Iterable[tuple[Stretch, dict[str, float]]], least: int = 1) -> list[Row]:
    """Statistics by name, for names with at least `least` examples, sorted by name.

    Medina 2023 keeps pairs with at least 86 examples and no consonant clusters (CC).
    """
    groups: dict[tuple[str, str], list[dict[str, float]]] = {}
    for stretch, measures in examples:
        groups.setdefault((stretch.name, stretch.kind), []).append(measures)
    return [_row(*key, group) for key, group in sorted(groups.items()) if len(group) >= least]


def _row(name: str, kind: str, group: list[dict[str, float]]) -> Row:
    measures = list(dict.fromkeys(measure for one in group for measure in one))
    table = np.array([[one.get(measure, np.nan) for measure in measures] for one in group])
    means, deviations = zip(*map(_spread, table.T), strict=True) if measures else ((), ())
    pairs = zip(measures, means, strict=True), zip(measures, deviations, strict=True)
    return Row(name, kind, len(group), dict(pairs[0]), dict(pairs[1]))


def _spread(values: Array) -> tuple[float, float]:
    """Mean and standard deviation (n - 1) of the values that are not NaN."""
    known = values[np.isfinite(values)]
    mean = float(known.mean()) if len(known) else np.nan
    return mean, float(known.std(ddof=1)) if len(known) > 1 else np.nan
