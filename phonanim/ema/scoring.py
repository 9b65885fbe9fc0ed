"""Predicted articulation against sensors: r, slope, ratio of deviations and error of each channel."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.core.decode import DecodeError, array_names
from phonanim.ema.channels import Recording, load_recordings
from phonanim.ema.utterances import EMU
from phonanim.errors import EvaluationError
from phonanim.evaluation.channels import articulation_of, channel_error, channel_measures
from phonanim.evaluation.predictions import Motion, line_name
from phonanim.evaluation.scoring import FEWEST, Scores
from phonanim.metrics import by_class, by_phone

SENSORS = ("sensors", "columns")  # arrays that an .npz of sensors has, and no animation


def is_articulography(path: Path) -> bool:
    """Whether a file, or a file of a folder, holds sensors: an EMU bundle, or an .npz of sensors."""
    if path.is_dir():
        return any(path.glob(f"*{EMU}")) or has_arrays(path)
    if path.suffix != ".npz":
        return path.name.endswith(EMU)
    try:
        return not array_names(path).isdisjoint(SENSORS)
    except (OSError, DecodeError):
        return False


def has_arrays(folder: Path) -> bool:
    """Whether a folder has an .npz of sensors."""
    return any(map(is_articulography, sorted(folder.glob("*.npz"))))


def find_recordings(path: Path, language: str = "auto", axes: str | None = None) -> dict[str, Recording]:
    """Recordings by name: all of a folder, or those of one file. Raises what `load_recordings` raises."""
    folder, name = (path, "") if path.is_dir() else (path.parent, path.name.removesuffix(EMU))
    found = {one.name: one for one in load_recordings(folder, language, axes)}
    if not name:
        return found
    stem = path.stem if path.suffix == ".npz" else name
    return {key: one for key, one in found.items() if stem in (key, one.speaker)}


def recording_of(prediction: Path, recordings: dict[str, Recording], source: Path) -> Recording:
    """The recording of a prediction: the only one, or the one of its name. Raises EvaluationError."""
    if len(recordings) == 1:
        return next(iter(recordings.values()))
    if line_name(prediction) not in recordings:
        raise EvaluationError(
            f"{source}: has no recording {line_name(prediction)!r}; it has {', '.join(sorted(recordings))}"
        )
    return recordings[line_name(prediction)]


def score_recording(predicted: Motion, recording: Recording) -> Scores:
    """Every channel that a take and the sensors share, over the speech of the recording.

    Raises EvaluationError when the take has no articulation, or no instants in common with the speech.
    """
    ours = articulation_of(predicted) if isinstance(predicted, Animation) else {}
    if not ours:
        raise EvaluationError(
            "the prediction has no articulation to compare with sensors; give an .npz that phonanim animate "
            "wrote, or use --rig articulation"
        )
    times = recording.times
    within = (times >= predicted.times[0]) & (times <= predicted.times[-1])
    said = recording.speech & within
    if said.sum() < FEWEST:
        raise EvaluationError(
            f"the prediction has {said.sum()} samples of the recording's speech; {FEWEST} are needed"
        )
    curves = {name: np.interp(times, predicted.times, curve) for name, curve in ours.items()}
    measures = channel_measures(curves, recording.curves, said, recording.in_mm)
    rate = 1 / float(np.diff(times).mean())
    scores = Scores(measures, int(said.sum()), rate, "articulation_error_mm", notes=recording.notes)
    if not recording.in_mm:
        unknown = "the unit of the sensors is unknown: only r is scored"
        return replace(scores, notes=(*recording.notes, unknown))
    error = channel_error(curves, recording.curves, said)[said]
    phones, classes = (tuple(table(error, times[said], recording.track)) for table in (by_phone, by_class))
    return replace(scores, phones=phones, classes=classes)
