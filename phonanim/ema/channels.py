"""Sensors -> the channels of phonanim.articulation, for recordings of several kinds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE, DecodeError, decode_number, read_arrays
from phonanim.ema.articulation import Articulation, orient_axes, standard_name
from phonanim.ema.utterances import load_utterances, read_spoken
from phonanim.errors import CorpusError, OptionError
from phonanim.inputs.alignment import read_alignment
from phonanim.metrics import speech_mask
from phonanim.speech.phones import PhoneTrack
from phonanim.targets.sensors import mouth_channels

Array = NDArray[np.float64]

# Standardized columns of the mngu0 release are scaled to about millimetres by the standard deviations (x, y)
# of the x-ray microbeam speaker JW11.
STANDARD = {
    "TD": (4.2, 4.3), "TB": (5.0, 5.7), "TT": (5.6, 6.4),
    "JAW": (1.0, 2.8), "UL": (1.7, 1.9), "LL": (2.9, 4.4),
}  # fmt: skip
SOUNDS = (".wav", ".flac")


FASTEST = 1e5  # samples of a sensor per second


@dataclass(frozen=True)
class Recording:
    """The motion of a mouth: `curves` (samples,) by channel at `times` (samples,) seconds of `track`.

    Each curve has its own offset, as sensors do. `speech` (samples,) is a mask of speech; `in_mm` is whether
    the unit is millimetres or unknown. `notes` say what was guessed.
    """

    name: str
    speaker: str
    track: PhoneTrack
    times: Array
    speech: NDArray[np.bool_]
    curves: dict[str, Array]
    in_mm: bool
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Sensed:
    """Sensors of a recording, x forward, y left, z up, with its phones; `audio` is its sound, if any.

    `notes` say what was guessed.
    """

    name: str
    speaker: str
    sensors: Articulation
    track: PhoneTrack
    in_mm: bool
    audio: Path | None = None
    notes: tuple[str, ...] = ()


def sensor_channels(articulation: Articulation) -> dict[str, Array]:
    """The channels of sensors (phonanim.targets.sensors), (samples,) each; x is forward, z up.

    Raises CorpusError without lip sensors.
    """
    articulation.sensor("UL"), articulation.sensor("LL")
    return mouth_channels(articulation.positions, tuple(map(standard_name, articulation.names)))


def load_recordings(folder: Path, language: str = "auto", axes: str | None = None) -> list[Recording]:
    """Recordings of a folder of EMU bundles, or of .npz arrays next to TextGrids of the same stem.

    `language` is that of the labels. `axes` are the directions of x, y and z in EMU bundles, found by the
    positions of the sensors without it.

    An .npz has `sensors` and `xyz` (samples, sensors, 3) mm, forward, left, up; or it has `columns`, and an
    array of standardized midsagittal columns (samples, columns) for each utterance, x towards the back.
    Raises CorpusError, LabelError, and OptionError for axes of .npz.
    """
    return [_recording(sensed) for sensed in load_sensed(folder, language, axes)]


def load_sensed(folder: Path, language: str = "auto", axes: str | None = None) -> list[Sensed]:
    """The sensors of the recordings of such a folder. Raises CorpusError, LabelError, OptionError."""
    found = [one for path in sorted(folder.glob("*.npz")) for one in _arrays(path, language)]
    if found and axes:
        raise OptionError(f"{folder}: an .npz of sensors has axes of its own; leave out --axes")
    return found or [
        Sensed(u.name, folder.name, u.articulation, u.track, True, u.audio, u.notes)
        for u in load_utterances(folder, language, axes)
    ]


def _arrays(path: Path, language: str) -> Iterator[Sensed]:
    try:
        arrays = read_arrays(path)
        rate = decode_number(arrays["hz"].item(), "hz", 1.0, FASTEST) if "hz" in arrays else 0.0
        _check_arrays(arrays)
    except (OSError, *DAMAGE) as error:
        raise CorpusError(f"{path}: cannot be read ({error}); fetch it again") from error
    if {"sensors", "xyz", "hz"} <= set(arrays):
        names = tuple(str(name) for name in arrays["sensors"])
        sensors = Articulation(names, arrays["xyz"].astype(np.float64), rate, source=str(path))
        yield _beside(path, path.stem, path.stem, sensors, True, language)
    elif {"columns", "hz"} <= set(arrays):
        for name in sorted(set(arrays) - {"columns", "hz"}):
            sensors = _columns(path, [str(c) for c in arrays["columns"]], arrays[name], rate)
            yield _beside(path, name, path.stem, sensors, False, language)


def _check_arrays(arrays: dict[str, NDArray[Any]]) -> None:
    """Raise DecodeError where an array has another shape or type than `load_recordings` says."""
    if "xyz" in arrays and arrays["xyz"].shape[1:] != (len(np.atleast_1d(arrays["sensors"])), 3):
        raise DecodeError(f"its positions of {arrays['xyz'].shape} are not (samples, sensors, 3)")
    for name in sorted(set(arrays) - {"columns", "hz", "sensors"}):
        if arrays[name].dtype.kind not in "fiu":
            raise DecodeError(f"{name} does not hold numbers")
        if "columns" in arrays and arrays[name].shape[1:] != arrays["columns"].shape:
            raise DecodeError(f"{name} of {arrays[name].shape} has not a column for each of columns")


def _columns(path: Path, columns: list[str], table: Array, rate: float) -> Articulation:
    """Standardized midsagittal columns as sensors in about millimetres, x towards the back."""
    names = tuple(dict.fromkeys(column[:-1] for column in columns))
    places = np.zeros((len(table), len(names), 3))
    for at, name in enumerate(names):
        for axis, letter, spread in zip((0, 2), "xy", STANDARD.get(name, (1.0, 1.0)), strict=True):
            places[:, at, axis] = spread * table[:, columns.index(name + letter)]
    return orient_axes(Articulation(names, places, rate, source=str(path)), "back,left,up")


def _beside(path: Path, name: str, speaker: str, sensors: Articulation, in_mm: bool, language: str) -> Sensed:
    track, notes = read_spoken(read_alignment(path.with_name(f"{name}.TextGrid")), language)
    sounds = [path.with_name(name + suffix) for suffix in SOUNDS]
    audio = next((sound for sound in sounds if sound.is_file()), None)
    return Sensed(name, speaker, sensors, track, in_mm, audio, notes)


def _recording(one: Sensed) -> Recording:
    curves, times = sensor_channels(one.sensors), one.sensors.times
    said = speech_mask(one.track, times) & (times < one.track.duration)
    tracked = np.all([np.isfinite(curve) for curve in curves.values()], axis=0)
    return Recording(one.name, one.speaker, one.track, times, said & tracked, curves, one.in_mm, one.notes)
