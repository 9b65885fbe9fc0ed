"""Convert public data sets into one layout: arrays, WAV, TextGrids, and a table of all recordings."""

from __future__ import annotations

import csv
import io
import json
import wave
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE, DecodeError, decode_number, decode_part, decode_whole, fault_reason
from phonanim.core.files import atomic_path, make_folder_within, write_text
from phonanim.datasets import Dataset, Frames, Recording, load_dataset
from phonanim.errors import CorpusError, OptionError
from phonanim.media.audio import HIGHEST_RATE, Sound
from phonanim.speech.textgrid import write_textgrid

RATES = (0.1, 1e5)  # frames per second
Rows = NDArray[np.int64]
COLUMNS = ("name", "speaker", "split", "frames", "fps", "seconds", "text", "emotion")


def import_dataset(
    name: str,
    folder: Path,
    output: Path,
    every: int = 1,
    splits: Sequence[str] = (),
    progress: Callable[[float], None] = lambda _: None,
    without: Rows | None = None,
) -> list[dict[str, Any]]:
    """Write the recordings of a data set into a folder, and return the rows of its table.

    motion/<name>.npy has every `every`-th frame; audio/<name>.wav is mono, 16 bits, at the rate of the data
    set; textgrid/<name>.TextGrid has the phones if there are any; templates/<subject>.npy is a face at rest,
    (vertices, 3), where the data set has some. recordings.csv and dataset.json are written last. `splits`
    names the splits to import; the default is all. `without` (n,) are vertices that are left out. Raises
    CorpusError, or OptionError for an unknown name, and for vertices of a data set that has none.
    """
    dataset = load_dataset(name)
    if without is not None and dataset.CARD.kind != "vertices":
        raise OptionError(f"--ignore-vertices: {name} has {dataset.CARD.kind}, not vertices; leave it out")
    with _told_of(str(folder)):
        recordings = [one for one in dataset.recordings(folder) if not splits or one.split in splits]
    if not recordings:
        raise CorpusError(f"{folder}: has no recordings of the split {', '.join(splits)}")
    for one in recordings:
        _check_name(one.name)
    for part in ("motion", "audio", "textgrid"):
        make_folder_within(output / part, output)
    rows, frames = [], Frames(np.zeros((0, 0), np.float32), 0.0)
    for number, recording in enumerate(recordings, start=1):
        with _told_of(f"{folder}: {recording.name}"):
            frames = _thinned(recording.frames(), every)
            if without is not None:
                frames = replace(frames, values=reduced(frames.values, without, 1))
            recording = _loaded(recording)
        rows.append(_write(recording, frames, output))
        progress(number / len(recordings))
    write_templates(dataset, folder, output, without, frames.values.shape[1])
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


def reduced(values: NDArray[np.float32], without: Rows, axis: int) -> NDArray[np.float32]:
    """Vertices along an axis, less some. Raises CorpusError for one that is not there."""
    if without.max(initial=0) >= values.shape[axis]:
        raise CorpusError(
            f"--ignore-vertices names vertex {without.max()}, and a frame has {values.shape[axis]} (from 0)"
        )
    return np.delete(values, without, axis=axis)


def write_templates(
    dataset: Dataset, folder: Path, output: Path, without: Rows | None = None, vertices: int = 0
) -> None:
    """Write the faces at rest of a data set that has some, templates/<subject>.npy (vertices, 3).

    Those that have more vertices than frames, `vertices`, are reduced as these are.
    """
    templates = getattr(dataset, "templates", None)
    with _told_of(str(folder)):
        rests = templates(folder) if templates else {}
    for subject, rest in rests.items():
        _check_name(subject)
        place = make_folder_within(output / "templates", output) / f"{subject}.npy"
        if without is not None and len(rest) != vertices:
            rest = reduced(rest, without, 0)
        with atomic_path(place) as partial, partial.open("wb") as file:
            np.save(file, rest)


def _loaded(recording: Recording) -> Recording:
    """The same with sound and phones that are read, and are some. Raises the exceptions of DAMAGE."""
    sound = recording.sound() if recording.sound else None
    if sound is not None:
        decode_whole(sound.rate, "samples per second", 1, HIGHEST_RATE)
    phones = recording.phones() if recording.phones else None
    read_sound, read_phones = (lambda: sound) if sound else None, (lambda: phones) if phones else None
    return replace(recording, sound=read_sound, phones=read_phones)


@contextmanager
def _told_of(what: str) -> Iterator[None]:
    """Data of another structure than that of their format are one line. Raises CorpusError."""
    try:
        yield
    except DAMAGE as error:
        raise CorpusError(f"{what}: is damaged ({type(error).__name__}: {fault_reason(error)})") from error


def _check_name(name: str) -> None:
    """Raise CorpusError for a name that is no plain name of a file."""
    try:
        decode_part(name, "a name")
    except DecodeError as error:
        raise CorpusError(f"{name!r:.80}: is not a valid file name; the data set is damaged") from error


def _thinned(frames: Frames, every: int) -> Frames:
    fps = decode_number(frames.fps, "fps", *RATES)
    return Frames(frames.values[::every], fps / every, frames.names, frames.unit)


def _write(recording: Recording, frames: Frames, output: Path) -> dict[str, Any]:
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
