"""Sensors -> the channels of phonanim.articulation, for recordings of several kinds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from phonanim.ema.articulation import Articulation, orient_axes
from phonanim.ema.utterances import load_utterances
from phonanim.errors import CorpusError
from phonanim.inputs.alignment import read_alignment
from phonanim.metrics import speech_mask
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]

# Standardized columns of the mngu0 release are scaled to about millimetres by the standard deviations (x, y)
# of the x-ray microbeam speaker JW11.
STANDARD = {
    "TD": (4.2, 4.3), "TB": (5.0, 5.7), "TT": (5.6, 6.4),
    "JAW": (1.0, 2.8), "UL": (1.7, 1.9), "LL": (2.9, 4.4),
}  # fmt: skip


@dataclass(frozen=True)
class Recording:
    """The motion of a mouth: `curves` (samples,) by channel at `times` (samples,) seconds of `track`.

    Each curve has its own offset, as sensors do. `speech` (samples,) is a mask of speech; `in_mm` is whether
    the unit is millimetres or unknown.
    """

    name: str
    speaker: str
    track: PhoneTrack
    times: Array
    speech: NDArray[np.bool_]
    curves: dict[str, Array]
    in_mm: bool


def sensor_channels(articulation: Articulation) -> dict[str, Array]:
    """The channels of sensors, (samples,) each; x is forward, z up. Raises CorpusError without lip sensors.

    The jaw is the sensor on the lower incisors. Lip gap and protrusion come from the sensors on both lips.
    The width is twice the distance of the mouth corner from the middle. The tongue's body is its dorsum.
    """
    upper, lower = articulation.sensor("UL"), articulation.sensor("LL")
    found = {
        "lip_gap": upper[:, 2] - lower[:, 2],
        "protrusion": (upper[:, 0] + lower[:, 0]) / 2,
        "upper_lip": upper[:, 2],
    }
    if articulation.has("LI"):
        found["jaw"] = -articulation.sensor("LI")[:, 2]
    if articulation.has("LC"):
        found["lip_width"] = 2 * np.abs(articulation.sensor("LC")[:, 1])
    for sensor, channel in (("TT", "tongue_tip"), ("TD", "tongue_body")):
        if articulation.has(sensor):
            place = articulation.sensor(sensor)
            found |= {f"{channel}_height": place[:, 2], f"{channel}_front": place[:, 0]}
    return found


def load_recordings(folder: Path) -> list[Recording]:
    """Recordings of a folder of EMU bundles, or of .npz arrays next to TextGrids of the same stem.

    An .npz has `sensors` and `xyz` (samples, sensors, 3) mm, forward, left, up; or it has `columns`, and an
    array of standardized midsagittal columns (samples, columns) for each utterance, x towards the back.
    Raises CorpusError.
    """
    found = [one for path in sorted(folder.glob("*.npz")) for one in _arrays(path)]
    if not found:
        return [
            _recording(u.name, folder.name, u.articulation, u.track, in_mm=True)
            for u in load_utterances(folder)
        ]
    return found


def _arrays(path: Path) -> Iterator[Recording]:
    try:
        with np.load(path) as stored:
            arrays: dict[str, Any] = {name: stored[name] for name in stored.files}
        rate = float(arrays["hz"]) if "hz" in arrays else 0.0
    except (OSError, ValueError, BadZipFile, TypeError) as error:
        raise CorpusError(f"{path}: cannot be read ({error}); fetch it again") from error
    if {"sensors", "xyz", "hz"} <= set(arrays):
        names = tuple(str(name) for name in arrays["sensors"])
        sensors = Articulation(names, arrays["xyz"].astype(np.float64), rate, source=str(path))
        yield _beside(path, path.stem, path.stem, sensors, in_mm=True)
    elif {"columns", "hz"} <= set(arrays):
        for name in sorted(set(arrays) - {"columns", "hz"}):
            sensors = _columns(path, [str(c) for c in arrays["columns"]], arrays[name], rate)
            yield _beside(path, name, path.stem, sensors, in_mm=False)


def _columns(path: Path, columns: list[str], table: Array, rate: float) -> Articulation:
    """Standardized midsagittal columns as sensors in about millimetres, x towards the back."""
    names = tuple(dict.fromkeys(column[:-1] for column in columns))
    places = np.zeros((len(table), len(names), 3))
    for at, name in enumerate(names):
        for axis, letter, spread in zip((0, 2), "xy", STANDARD.get(name, (1.0, 1.0)), strict=True):
            places[:, at, axis] = spread * table[:, columns.index(name + letter)]
    return orient_axes(Articulation(names, places, rate, source=str(path)), "back,left,up")


def _beside(path: Path, name: str, speaker: str, sensors: Articulation, in_mm: bool) -> Recording:
    alignment = read_alignment(path.with_name(f"{name}.TextGrid"))
    return _recording(name, speaker, sensors, to_phones(alignment, "english")[0], in_mm)


def _recording(name: str, speaker: str, sensors: Articulation, track: PhoneTrack, in_mm: bool) -> Recording:
    curves, times = sensor_channels(sensors), sensors.times
    said = speech_mask(track, times) & (times < track.duration)
    tracked = np.all([np.isfinite(curve) for curve in curves.values()], axis=0)
    return Recording(name, speaker, track, times, said & tracked, curves, in_mm)
