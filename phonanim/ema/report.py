"""Measure a folder of recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.ema.articulation import (
    OUR_AXES,
    Articulation,
    orient_axes,
    rename_sensors,
    standard_name,
)
from phonanim.ema.examples import (
    Row,
    Stretch,
    diphone_stretches,
    measure_stretch,
    measured_curves,
    phone_stretches,
    side_sums,
    summarize_examples,
)
from phonanim.ema.measures import Envelope, envelope
from phonanim.ema.posture import Posture, correct_head_motion
from phonanim.ema.preparation import Gap, fill_gaps, resample_sensors
from phonanim.ema.utterances import Spoken
from phonanim.errors import CorpusError
from phonanim.evaluation.statistics import pearson
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
JAWS = ("LI", "LJ")  # sensors of the jaw


@dataclass(frozen=True)
class Preparation:
    """Preparation of recordings: channel names, axes, head correction, and the rate in hertz.

    Without `axes`, x, y and z of the files are forward, left and up. `plate` is the name of the recording of
    the bite plate, which is no speech.
    """

    names: tuple[str, ...] = ()
    axes: str | None = None
    posture: Posture | None = None
    rate: float | None = None
    plate: str = ""


@dataclass(frozen=True)
class PreparedRecording:
    """A prepared recording: its sensors, their gaps, and its phones."""

    name: str
    articulation: Articulation
    gaps: list[Gap]
    track: PhoneTrack


@dataclass(frozen=True)
class Report:
    """Statistics of recordings; `places` are positions of every sensor, (samples, 3) mm, `first` one take.

    `motions` are the starts and ends of every sensor in each example of a pair of phones, (examples, 2,
    sensors, 3) mm.
    """

    recordings: list[dict[str, Any]]
    phones: list[Row]
    diphones: list[Row]
    sides: list[dict[str, Any]]
    places: dict[str, Array]
    jaws: dict[str, Envelope]
    motions: dict[str, Array]
    first: PreparedRecording


def prepare_sensors(raw: Articulation, preparation: Preparation) -> tuple[Articulation, list[Gap]]:
    """Name the channels, fill short gaps, remove head motion, turn the axes, and change the rate.

    Raises CorpusError without samples or without these sensors, and OptionError.
    """
    if len(raw.positions) == 0:
        raise CorpusError(f"{raw.source}: has no samples; fetch it again, or remove it")
    if preparation.names:
        raw = rename_sensors(raw, preparation.names)
    whole, gaps = fill_gaps(raw)
    if preparation.posture is not None:
        whole = correct_head_motion(whole, preparation.posture)
    turned = orient_axes(whole, preparation.axes or OUR_AXES)
    return (resample_sensors(turned, preparation.rate) if preparation.rate else turned), gaps


def prepare_recording(spoken: Spoken, preparation: Preparation, language: str = "auto") -> PreparedRecording:
    """Read and prepare a recording. Raises CorpusError, AlignmentError, LabelError."""
    articulation, gaps = prepare_sensors(spoken.sensors(), preparation)
    return PreparedRecording(spoken.name, articulation, gaps, to_phones(spoken.alignment(), language)[0])


@dataclass(frozen=True)
class Measured:
    """A recording with its examples, and the sums of `side_sums` for each pair of phones."""

    take: PreparedRecording
    phones: list[tuple[Stretch, dict[str, float]]]
    diphones: list[tuple[Stretch, dict[str, float]]]
    sides: list[tuple[str, dict[tuple[str, str, str], Array]]]


def measure(one: PreparedRecording) -> Measured:
    """Measure every phone and every pair of phones of a recording."""
    articulation, pairs = one.articulation, diphone_stretches(one.track)
    found = measured_curves(articulation)
    return Measured(
        one,
        [(phone, measure_stretch(phone, found, articulation)) for phone in phone_stretches(one.track)],
        [(pair, measure_stretch(pair, found, articulation)) for pair in pairs],
        [(pair.name, side_sums(pair, articulation)) for pair in pairs],
    )


def make_report(
    recordings: Sequence[Spoken],
    preparation: Preparation,
    language: str = "auto",
    least: int = 1,
    progress: Callable[[float], None] = lambda _: None,
) -> Report:
    """Measure recordings that have the same sensors. Raises CorpusError.

    Pairs of phones with fewer than `least` examples are left out.
    """
    done: list[Measured] = []
    for number, spoken in enumerate(recordings, start=1):
        done.append(measure(prepare_recording(spoken, preparation, language)))
        _check_alike(done[0].take.articulation, done[-1].take.articulation)
        progress(number / len(recordings))
    places = _places([one.take.articulation for one in done])
    diphones = summarize_examples([example for one in done for example in one.diphones], least)
    return Report(
        recordings=[_facts(one.take) for one in done],
        phones=summarize_examples([example for one in done for example in one.phones]),
        diphones=diphones,
        sides=_side_rows(done, {row.name for row in diphones}),
        places=places,
        jaws={name: envelope(places[name]) for name in JAWS if name in places},
        motions=_motions([one.take for one in done], {row.name for row in diphones}),
        first=done[0].take,
    )


def _check_alike(first: Articulation, other: Articulation) -> None:
    if other.names != first.names:
        raise CorpusError(
            f"{other.source}: has the sensors {', '.join(other.names)}; {first.source} has "
            f"{', '.join(first.names)}; make a report of each alone"
        )


def _places(articulations: Sequence[Articulation]) -> dict[str, Array]:
    """Positions of every sensor in all recordings, (samples, 3) mm."""
    cloud = np.concatenate([articulation.positions for articulation in articulations])
    return {standard_name(name): cloud[:, at] for at, name in enumerate(articulations[0].names)}


def _motions(takes: Sequence[PreparedRecording], names: set[str]) -> dict[str, Array]:
    """Where every sensor starts and ends in the examples of pairs of phones, (examples, 2, sensors, 3) mm."""
    found: dict[str, list[Array]] = {name: [] for name in sorted(names)}
    for take in takes:
        positions, times = take.articulation.positions, take.articulation.times
        for pair in diphone_stretches(take.track):
            ends = np.searchsorted(times, (pair.start, pair.end)).clip(0, len(times) - 1)
            if pair.name in names:
                found[pair.name].append(positions[ends])
    return {name: np.stack(examples) for name, examples in found.items() if examples}


def _facts(one: PreparedRecording) -> dict[str, Any]:
    return {
        "name": one.name,
        "seconds": len(one.articulation.positions) / one.articulation.rate,
        "rate_hz": one.articulation.rate,
        "phones": len(phone_stretches(one.track)),
        "gaps": [asdict(gap) for gap in one.gaps],
    }


def _side_rows(done: Sequence[Measured], names: set[str]) -> list[dict[str, Any]]:
    totals: dict[tuple[str, ...], Array] = {}
    for name, sums in (pair for one in done for pair in one.sides if pair[0] in names):
        for key, row in sums.items():
            place = (name, *key)
            totals[place] = totals.get(place, 0) + row
    columns = "diphone", "midsagittal", "side", "axis"
    return [
        {**dict(zip(columns, key, strict=True)), "samples": int(total[0]), "r": float(pearson(total))}
        for key, total in sorted(totals.items())
    ]
