"""Recordings of sensors with their phones: EMU bundles, imported data sets, others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE, decode_number, read_array, read_json
from phonanim.ema.articulation import Articulation, orient_axes
from phonanim.ema.orientation import axes_or_ours
from phonanim.ema.readers import read_articulation
from phonanim.errors import CorpusError
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.alignment import Alignment
from phonanim.speech.language import read_phones
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
RUN_ON = 1.0  # seconds; a longer last segment includes the silence after the speech
LAST = 0.12  # seconds that such a segment is shortened to
EMU = "_bndl.json"
AXES = 3
SENSORS = (".pos", ".mat")
ALIGNMENTS = (".TextGrid", ".textgrid", ".lab", ".phn", ".csv", ".json", ".eaf")


@dataclass(frozen=True)
class Spoken:
    """A recording that is loaded on demand: its sensors, and its phones."""

    name: str
    sensors: Callable[[], Articulation]
    alignment: Callable[[], Alignment]


@dataclass(frozen=True)
class Utterance:
    """`aperture` (samples,) mm is the vertical distance of the lip sensors at `times` (samples,) s.

    `speech` (samples,) is a mask of speech, `audio` is the recording, `articulation` has all sensors. `notes`
    say what was guessed.
    """

    name: str
    track: PhoneTrack
    times: Array
    fps: float
    aperture: Array
    speech: NDArray[np.bool_]
    audio: Path
    articulation: Articulation
    notes: tuple[str, ...] = ()


def load_utterances(folder: Path, language: str = "auto", axes: str | None = None) -> list[Utterance]:
    """Every utterance of a folder of EMU bundles with lip sensors next to them.

    Without `axes`, the directions of x, y and z, they are found by the positions of the sensors. Raises
    CorpusError, LabelError, and OptionError for axes.
    """
    found = find_spoken(folder)
    told: tuple[str, ...] = ()
    if axes is None:
        axes, how = axes_or_ours(spoken.sensors() for spoken in found)
        told = (how,)
    return [_utterance(spoken, folder, language, axes, told) for spoken in found]


def read_spoken(alignment: Alignment, language: str) -> tuple[PhoneTrack, tuple[str, ...]]:
    """The phones of an alignment, and notes, one of which says the language that was guessed.

    Raises LabelError.
    """
    reading = read_phones(alignment, language)
    guessed = reading.language.by == "labels"
    how = f"the labels are read as {reading.language.language.name}; --language gives another"
    return reading.track, (*(how,) * guessed, *reading.notes)


def find_spoken(folder: Path) -> list[Spoken]:
    """The recordings of a folder, sorted by name.

    The folder was written by `phonanim corpus import`, or has EMU bundles (`*_bndl.json` next to SSFF files),
    or .pos and .mat files next to alignments of the same stem. Raises CorpusError for any other folder.
    """
    found = list(_imported(folder) if (folder / "dataset.json").is_file() else _bundles(folder))
    found = found or list(_files(folder))
    if not found:
        raise CorpusError(
            f"{folder}: has no articulography; looked for dataset.json, *{EMU}, and .pos or .mat files"
        )
    return sorted(found, key=lambda spoken: spoken.name)


def _bundles(folder: Path) -> Iterator[Spoken]:
    for path in folder.glob(f"*{EMU}"):
        name = path.name.removesuffix(EMU)
        yield Spoken(name, partial(_ssff, folder, name), partial(_bundle_phones, path))


def _ssff(folder: Path, name: str) -> Articulation:
    """The sensors of a bundle; reading the first file finds the others."""
    from phonanim.ema.readers import ssff

    tracks = [path for path in sorted(folder.glob(f"{name}.*")) if ssff.recognizes(path)]
    if not tracks:
        raise CorpusError(f"{folder / name}: has no SSFF files next to {name}{EMU}; put them there")
    return read_articulation(tracks[0])


def _bundle_phones(path: Path) -> Alignment:
    return _without_run_on(read_alignment(path))


def _files(folder: Path) -> Iterator[Spoken]:
    for path in folder.iterdir():
        if path.suffix.lower() in SENSORS:
            yield Spoken(path.stem, partial(read_articulation, path), partial(_beside, path))


def _beside(path: Path) -> Alignment:
    found = [path.with_suffix(suffix) for suffix in ALIGNMENTS if path.with_suffix(suffix).is_file()]
    if not found:
        raise CorpusError(f"{path}: has no alignment next to it; add {path.stem}.TextGrid (phonanim align)")
    return read_alignment(found[0])


def _imported(folder: Path) -> Iterator[Spoken]:
    path = folder / "dataset.json"
    try:
        facts = read_json(path)
        kind, names, rate = facts["kind"], tuple(facts["names"]), decode_number(facts["fps"], "fps", 1.0, 1e5)
    except (OSError, *DAMAGE) as error:
        raise CorpusError(f"{path}: is damaged ({error!r}); import the data set again") from error
    if kind != "sensors":
        raise CorpusError(f"{folder}: has {kind} and no sensors; mngu0, mocha, hprc have some")
    for motion in (folder / "motion").glob("*.npy"):
        beside = folder / "textgrid" / motion.name
        yield Spoken(motion.stem, partial(_motion, motion, names, rate), partial(_beside, beside))


def _motion(path: Path, names: tuple[str, ...], rate: float) -> Articulation:
    """Imported arrays; those of the midsagittal plane get a lateral axis of zeros."""
    try:
        values = read_array(path).astype(np.float64)
    except (OSError, ValueError) as error:
        raise CorpusError(f"{path}: is not an array ({error}); import the data set again") from error
    if values.ndim != AXES or values.shape[2] not in (AXES - 1, AXES):
        raise CorpusError(f"{path}: is {values.shape}; sensors are (samples, sensors, 2 or 3)")
    if values.shape[2] == AXES - 1:
        values = np.insert(values, 1, 0.0, axis=2)
    names = names or tuple(str(number + 1) for number in range(values.shape[1]))
    return Articulation(names, values, rate, source=str(path))


def _utterance(spoken: Spoken, folder: Path, language: str, axes: str, told: tuple[str, ...]) -> Utterance:
    articulation = orient_axes(spoken.sensors(), axes)
    track, notes = read_spoken(spoken.alignment(), language)
    times, said = articulation.times, np.flatnonzero(track.codes)
    aperture = articulation.sensor("UL")[:, 2] - articulation.sensor("LL")[:, 2]
    speech = np.isfinite(aperture) & bool(len(said))
    if len(said):
        speech &= (times >= track.bounds[said[0]]) & (times < track.bounds[said[-1] + 1])
    audio, rate = folder / f"{spoken.name}.wav", articulation.rate
    return Utterance(spoken.name, track, times, rate, aperture, speech, audio, articulation, (*told, *notes))


def _without_run_on(alignment: Alignment) -> Alignment:
    """End the last sound where speech ends; the labels include 1 to 2 s of silence in it."""
    kept = [
        replace(i, end=i.start + LAST) if i.end - i.start > RUN_ON and i.label[:1] != "&" else i
        for i in alignment.intervals
    ]
    return replace(alignment, intervals=tuple(kept))
