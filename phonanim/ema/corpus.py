"""Recordings of articulography -> a training corpus of sensors (phonanim/targets/sensors.py)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import atomic_path
from phonanim.corpus.motion import MotionClip, MotionCorpus, save_motion_corpus
from phonanim.ema.articulation import Articulation, standard_name
from phonanim.ema.channels import Sensed, load_sensed
from phonanim.ema.preparation import fill_gaps, resample_sensors
from phonanim.ema.report import Preparation, prepare_sensors
from phonanim.ema.scoring import is_articulography
from phonanim.ema.utterances import find_spoken
from phonanim.errors import CorpusError
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack
from phonanim.targets import Source

Array = NDArray[np.float64]
RATE = 50.0  # hertz, as in Medina et al. 2022
AFTER = 0.2  # seconds kept after the last phone
MOST_LOST = 0.2  # share of lost samples of a sensor above which a recording is left out
DEFAULT = Preparation(rate=RATE)
SOUNDS = (".wav", ".flac")
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
    splits: dict[str, str] | None = None,
    progress: Callable[[float], None] = lambda done: None,
) -> SensorReport:
    """Write the corpus of a folder of EMU bundles, .npz of sensors, .pos or .mat files, or an imported one.

    The sensors that all recordings have are kept, at the rate of `preparation`, up to the end of speech.
    `splits` are those of recordings by name; all are for training by default. Raises CorpusError.
    """
    sensed = (
        load_sensed(folder) if is_articulography(folder) else load_prepared(folder, preparation, language)
    )
    names, clips, left_out = common_sensors(sensed), list[MotionClip](), dict[str, str]()
    rate = preparation.rate or RATE
    (destination / "motion").mkdir(parents=True, exist_ok=True)
    for number, one in enumerate(sensed, start=1):
        values, lost = sensor_frames(one, names, rate)
        if lost > MOST_LOST:
            left_out[one.name] = f"{lost:.0%} of a sensor is lost"
            continue
        motion = destination / "motion" / f"{one.name}.npy"
        with atomic_path(motion) as path, path.open("wb") as file:
            np.save(file, values.astype(np.float32))
        split, audio = (splits or {}).get(one.name, "train"), one.audio
        clips.append(
            MotionClip(one.name, one.speaker, split, len(values), motion, audio, one.track, aligned=True)
        )
        progress(number / len(sensed))
    if not clips:
        raise CorpusError(f"{folder}: no recording can be used; {next(iter(left_out.values()), '')}")
    unit = "mm" if all(one.in_mm for one in sensed) else "about mm"
    corpus = MotionCorpus(
        "sensors", rate, Source(folder.name, names, unit), tuple(clips), {"source": folder.name}
    )
    save_motion_corpus(corpus, destination)
    return SensorReport(corpus, left_out)


def load_prepared(folder: Path, preparation: Preparation, language: str) -> list[Sensed]:
    """Recordings of files whose axes and names `preparation` tells. Raises CorpusError."""
    found = []
    for spoken in find_spoken(folder):
        sensors, _ = prepare_sensors(
            spoken.sensors(), Preparation(preparation.names, preparation.axes, preparation.posture)
        )
        track = to_phones(spoken.alignment(), language)[0]
        found.append(Sensed(spoken.name, folder.name, sensors, track, True, find_sound(folder, spoken.name)))
    return found


def find_sound(folder: Path, name: str) -> Path | None:
    """The sound of a recording, beside it or in audio/."""
    paths = [
        place / f"{name}{suffix}" for place in (folder, folder / "audio") for suffix in (".wav", ".flac")
    ]
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
        frames = [np.load(clip.motion) for clip in clips if clip.subject == subject]
        found[subject] = np.concatenate(frames).mean(axis=0, dtype=np.float64)
    return found


def speech_end(track: PhoneTrack) -> float:
    """The end of the last phone that is not silence, seconds."""
    said = np.flatnonzero(track.codes)
    return float(track.bounds[said[-1] + 1]) if len(said) else track.duration
