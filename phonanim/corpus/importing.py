"""Convert public data sets into one layout: arrays, WAV, TextGrids, and a table of all recordings."""

from __future__ import annotations

import csv
import io
import json
import wave
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.core.files import atomic_path, write_text
from phonanim.datasets import Dataset, Frames, Recording, load_dataset
from phonanim.errors import CorpusError
from phonanim.media.audio import Sound
from phonanim.speech.textgrid import write_textgrid

COLUMNS = ("name", "speaker", "split", "frames", "fps", "seconds", "text", "emotion")


def import_dataset(
    name: str,
    folder: Path,
    output: Path,
    every: int = 1,
    splits: Sequence[str] = (),
    progress: Callable[[float], None] = lambda _: None,
) -> list[dict[str, Any]]:
    """Write the recordings of a data set into a folder, and return the rows of its table.

    motion/<name>.npy has every `every`-th frame; audio/<name>.wav is mono, 16 bits, at the rate of the data
    set; textgrid/<name>.TextGrid has the phones if there are any; templates/<subject>.npy is a face at rest,
    (vertices, 3), where the data set has some. recordings.csv and dataset.json are written last. `splits`
    names the splits to import; the default is all. Raises CorpusError, or OptionError for an unknown name.
    """
    dataset = load_dataset(name)
    recordings = [one for one in dataset.recordings(folder) if not splits or one.split in splits]
    if not recordings:
        raise CorpusError(f"{folder}: has no recordings of the split {', '.join(splits)}")
    for part in ("motion", "audio", "textgrid"):
        (output / part).mkdir(parents=True, exist_ok=True)
    rows, frames = [], Frames(np.zeros((0, 0), np.float32), 0.0)
    for number, recording in enumerate(recordings, start=1):
        frames = _thinned(recording.frames(), every)
        rows.append(_write(recording, frames, output))
        progress(number / len(recordings))
    write_templates(dataset, folder, output)
    facts = {
        "name": name,
        **asdict(dataset.CARD),
        "names": frames.names,
        "unit": frames.unit,
        "fps": frames.fps,
    }
    write_text(output / "recordings.csv", _table(rows))
    write_text(output / "dataset.json", json.dumps(facts, indent=1, ensure_ascii=False) + "\n")
    return rows


def write_templates(dataset: Dataset, folder: Path, output: Path) -> None:
    """Write the faces at rest of a data set that has some, templates/<subject>.npy (vertices, 3)."""
    templates = getattr(dataset, "templates", None)
    for subject, rest in (templates(folder) if templates else {}).items():
        if Path(subject).name != subject:
            raise CorpusError(
                f"{folder}: the template {subject!r} has no valid name; the data set is damaged"
            )
        (output / "templates").mkdir(parents=True, exist_ok=True)
        with atomic_path(output / "templates" / f"{subject}.npy") as partial, partial.open("wb") as file:
            np.save(file, rest)


def _thinned(frames: Frames, every: int) -> Frames:
    return Frames(frames.values[::every], frames.fps / every, frames.names, frames.unit)


def _write(recording: Recording, frames: Frames, output: Path) -> dict[str, Any]:
    if Path(recording.name).name != recording.name:
        raise CorpusError(f"{recording.name}: is not a valid file name; the data set is damaged")
    seconds = len(frames.values) / frames.fps
    with atomic_path(output / "motion" / f"{recording.name}.npy") as partial:
        np.save(partial, frames.values)
    if recording.sound:
        sound = recording.sound()
        seconds = sound.duration
        write_wav(output / "audio" / f"{recording.name}.wav", sound)
    if recording.phones and (phones := recording.phones()):
        path = output / "textgrid" / f"{recording.name}.TextGrid"
        write_textgrid(path, {"phones": phones}, max(seconds, phones[-1].end))
    cells = recording.name, recording.speaker, recording.split, len(frames.values), frames.fps, seconds
    return dict(zip(COLUMNS, (*cells, recording.text, recording.emotion), strict=True))


def write_wav(path: Path, sound: Sound) -> None:
    """Write 16-bit mono WAV; samples beyond full scale are clipped. Raises OutputError."""
    samples = np.round(np.clip(sound.samples, -1, 1) * 32767).astype("<i2")
    with atomic_path(path) as partial, wave.open(str(partial), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(sound.rate)
        stream.writeframes(samples.tobytes())


def _table(rows: Sequence[dict[str, Any]]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
