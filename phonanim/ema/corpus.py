"""Recordings of articulography -> a training corpus of sensors (phonanim/targets/sensors.py)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import map_array
from phonanim.core.files import atomic_path, make_folder_within
from phonanim.corpus.motion import MotionClip, MotionCorpus, save_motion_corpus
from phonanim.corpus.motion_build import card_of, guess_splits, read_imported
from phonanim.ema.articulation import Articulation, rename_sensors, standard_name
from phonanim.ema.channels import Sensed, load_sensed
from phonanim.ema.orientation import axes_or_ours
from phonanim.ema.preparation import fill_gaps, resample_sensors
from phonanim.ema.report import Preparation, prepare_sensors
from phonanim.ema.scoring import has_arrays
from phonanim.ema.utterances import Spoken, find_spoken
from phonanim.errors import CorpusError, OptionError
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack, silent_track
from phonanim.targets import Source

Array = NDArray[np.float64]
RATE = 50.0  # hertz, as in Medina et al. 2022
AFTER = 0.2  # seconds kept after the last phone
MOST_LOST = 0.2  # share of lost samples of a sensor above which a recording is left out
DEFAULT = Preparation(rate=RATE)
SOUNDS = (".wav", ".flac")
MOTION = "sensors"  # folder of the motion of the corpus, beside that of an import
ORDER = ("TT", "TB", "TD", "BL", "BR", "UL", "LL", "LC", "LI", "LJ")


@dataclass(frozen=True)
class SensorReport:
    """The corpus, and the recordings that were left out with the reason."""

    corpus: MotionCorpus
    left_out: dict[str, str]


def build_sensor_corpus(
    folder: Path,
    destination: Path,
    preparation: Preparation = DEFAULT,
    language: str = "auto",
    progress: Callable[[float], None] = lambda done: None,
) -> SensorReport:
    """Write the corpus of a folder of EMU bundles, .npz of sensors, .pos or .mat files, or an imported one.

    The sensors that all recordings have are kept, at the rate of `preparation`, up to the end of speech.
    Without axes in `preparation` they are found by the positions of the sensors. Speakers and splits are
    those of an import; otherwise all is for training. Raises CorpusError, and OptionError for names or axes
    of .npz, which has its own.
    """
    listed, guessed = read_listed(folder), list[str]()
    if has_arrays(folder):
        check_arrays_options(preparation)
        sensed = load_sensed(folder, language)
    else:
        sensed = load_prepared(folder, preparation, language, guessed)
    guessed += listed.guessed
    sensed = [one for one in sensed if not listed.splits or listed.splits.get(one.name)]
    if not sensed:
        raise CorpusError(f"{folder}: no recording has a split; import those of the split train")
    names, clips, left_out = common_sensors(sensed), list[MotionClip](), dict[str, str]()
    rate = preparation.rate or RATE
    make_folder_within(destination / MOTION, destination)
    for number, one in enumerate(sensed, start=1):
        values, lost = sensor_frames(one, names, rate)
        if lost > MOST_LOST:
            left_out[one.name] = f"{lost:.0%} of a sensor is lost"
            continue
        motion = destination / MOTION / f"{one.name}.npy"
        with atomic_path(motion) as path, path.open("wb") as file:
            np.save(file, values.astype(np.float32))
        subject, split = listed.speakers.get(one.name, one.speaker), listed.splits.get(one.name, "train")
        spoken = bool(one.track.codes.any())
        clips.append(
            MotionClip(one.name, subject, split, len(values), motion, one.audio, one.track, aligned=spoken)
        )
        progress(number / len(sensed))
    if not clips:
        raise CorpusError(f"{folder}: no recording can be used; {next(iter(left_out.values()))}")
    unit = "mm" if all(one.in_mm for one in sensed) else "about mm"
    source = Source(listed.data or folder.name, names, unit, mean_positions(clips))
    about = {"source": folder.name, **listed.card, "guessed": guessed}
    corpus = MotionCorpus("sensors", rate, source, tuple(clips), about)
    save_motion_corpus(corpus, destination)
    return SensorReport(corpus, left_out)


@dataclass(frozen=True)
class Listed:
    """What an import tells of its recordings by name; empty for folders that were not imported."""

    data: str = ""
    splits: Mapping[str, str] = field(default_factory=dict)
    speakers: Mapping[str, str] = field(default_factory=dict)
    card: Mapping[str, str] = field(default_factory=dict)
    guessed: tuple[str, ...] = ()


def read_listed(folder: Path) -> Listed:
    """The table of an imported folder. Raises CorpusError when it is damaged."""
    if not (folder / "dataset.json").is_file():
        return Listed()
    facts, rows = read_imported(folder)
    guessed = guess_splits(rows)
    splits = {row["name"]: row["split"] for row in rows}
    speakers = {row["name"]: row["speaker"] for row in rows}
    return Listed(str(facts.get("name", "")), splits, speakers, card_of(facts), guessed)


def check_arrays_options(preparation: Preparation) -> None:
    """Raise OptionError for what an .npz of sensors says itself."""
    if preparation.names or preparation.axes or preparation.posture is not None:
        raise OptionError(
            "--names, --axes, --reference: an .npz of sensors has names, and axes forward, left and up; "
            "leave them out"
        )


def load_prepared(folder: Path, preparation: Preparation, language: str, guessed: list[str]) -> list[Sensed]:
    """Recordings of files whose axes and names `preparation` tells; without phones, they are silent.

    What is said of the axes that were found is added to `guessed`. Raises CorpusError.
    """
    spokens = [one for one in find_spoken(folder) if one.name != preparation.plate]
    if not preparation.axes and not preparation.plate:
        preparation = replace(preparation, axes=axes_of(spokens, preparation.names, guessed))
    found, as_recorded = [], replace(preparation, rate=None)
    for spoken in spokens:
        sensors, _ = prepare_sensors(spoken.sensors(), as_recorded)
        try:
            track = to_phones(spoken.alignment(), language, unknown="nearest")[0]
        except CorpusError:  # it has no alignment beside it
            track = silent_track(max(len(sensors.positions) / sensors.rate, 1e-3))
        found.append(Sensed(spoken.name, folder.name, sensors, track, True, find_sound(folder, spoken.name)))
    return found


def axes_of(spokens: Sequence[Spoken], names: tuple[str, ...], guessed: list[str]) -> str:
    """The directions of x, y and z by the positions of the sensors; `guessed` gets a line that says so."""
    raw = (spoken.sensors() for spoken in spokens)
    axes, told = axes_or_ours(rename_sensors(one, names) if names else one for one in raw)
    guessed.append(told)
    return axes


def find_sound(folder: Path, name: str) -> Path | None:
    """The sound of a recording, beside it or in audio/."""
    paths = [place / f"{name}{suffix}" for place in (folder, folder / "audio") for suffix in SOUNDS]
    return next((path for path in paths if path.is_file()), None)


def common_sensors(sensed: Sequence[Sensed]) -> tuple[str, ...]:
    """The sensors that all recordings have, by their names in lexicon/sensors.csv. Raises CorpusError."""
    shared = set.intersection(*(set(map(standard_name, one.sensors.names)) for one in sensed))
    names = tuple(name for name in ORDER if name in shared)
    if not names:
        raise CorpusError("the recordings have no sensor in common; name them with --names")
    return names


def sensor_frames(one: Sensed, names: tuple[str, ...], rate: float) -> tuple[Array, float]:
    """Sensors up to the end of speech, (frames, sensors, 3) mm at n / rate seconds; the greatest share lost.

    Short gaps are filled by lines before the rate is changed, longer ones after it.
    """
    whole = fill_gaps(one.sensors)[0]
    chosen = np.stack([whole.sensor(name) for name in names], axis=1)
    sensors = resample_sensors(Articulation(names, chosen, whole.rate, whole.start, whole.source), rate)
    count = max(2, round((speech_end(one.track) + AFTER) * rate))
    before = max(0, round(sensors.start * rate))  # frames before the first sample
    values = np.concatenate([np.full((before, len(names), 3), np.nan), sensors.positions])[:count]
    known = np.isfinite(values).all(axis=2)
    for place in range(len(names)):
        kept = np.flatnonzero(known[:, place])
        if len(kept):
            for axis in range(3):
                values[:, place, axis] = np.interp(np.arange(len(values)), kept, values[kept, place, axis])
    return values, float((1 - known.mean(axis=0)).max())


def mean_positions(clips: Sequence[MotionClip]) -> dict[str, Array]:
    """The mean position of the sensors of each subject, (sensors, 3) mm."""
    found: dict[str, Array] = {}
    for subject in sorted({clip.subject for clip in clips}):
        frames = [map_array(clip.motion) for clip in clips if clip.subject == subject]
        found[subject] = np.concatenate(frames).mean(axis=0, dtype=np.float64)
    return found


def speech_end(track: PhoneTrack) -> float:
    """The end of the last phone that is not silence, seconds."""
    said = np.flatnonzero(track.codes)
    return float(track.bounds[said[-1] + 1]) if len(said) else track.duration
