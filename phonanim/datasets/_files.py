"""Common parts of several layouts: sounds and arrays in folders, lists of names, numbers in names."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import MAX_TEXT, DecodeError, read_array, read_utf8
from phonanim.datasets import Frames, Recording
from phonanim.datasets._pickles import read_pickle
from phonanim.errors import CorpusError
from phonanim.media.audio import Sound, read_sound

Split = Callable[[str, str], str]  # speaker, sentence -> split


def sound_loader(path: Path) -> Callable[[], Sound] | None:
    """A function that reads a recording, or None if there is no file."""
    return partial(read_sound, path) if path.is_file() else None


def load_array(path: Path) -> NDArray[np.float32]:
    """Numbers of a `.npy` file. Raises CorpusError when it is damaged; pickled objects are refused."""
    try:
        return read_array(path).astype(np.float32)
    except (OSError, ValueError) as error:
        raise CorpusError(f"{path}: cannot be read as an array of numbers: {error}") from error


def last_number(path: Path) -> tuple[int, str]:
    """A sort key of files by the last number in their stem."""
    found = re.findall(r"\d+", path.stem)
    return int(found[-1]) if found else -1, path.name


def read_list(path: Path) -> tuple[str, ...]:
    """The names in a text file, one per line. Raises CorpusError."""
    try:
        return tuple(read_utf8(path, MAX_TEXT).split())
    except (OSError, DecodeError) as error:
        raise CorpusError(f"{path}: cannot be read as a list of names: {error}") from error


def faceformer_recordings(
    folder: Path, fps: float, split: Split, axes: int, unit: str = "", names: tuple[str, ...] = ()
) -> Iterator[Recording]:
    """Recordings in the layout of FaceFormer: `vertices_npy/<speaker>_<sentence>.npy` next to `wav/` with
    the same names. Arrays are (frames, vertices * axes), or (frames, controls) with `axes` 1.
    """
    for path in sorted((folder / "vertices_npy").glob("*.npy")):
        speaker, _, sentence = path.stem.rpartition("_")
        yield Recording(
            path.stem,
            speaker,
            split(speaker, sentence),
            partial(frames_of, path, fps, axes, names, unit),
            sound_loader(folder / "wav" / f"{path.stem}.wav"),
        )


def frames_of(path: Path, fps: float, axes: int, names: tuple[str, ...] = (), unit: str = "") -> Frames:
    """Motion of a `.npy` file. Raises CorpusError when its shape does not match the names or axes."""
    values = load_array(path)
    flat = values.reshape(len(values), -1) if values.ndim else values
    if flat.ndim != 2 or flat.shape[1] % axes or (names and flat.shape[1] != axes * len(names)):
        wanted = axes * len(names) if names else f"a multiple of {axes}"
        raise CorpusError(f"{path}: has the shape {values.shape}; frames need {wanted} numbers each")
    return Frames(flat.reshape(len(flat), -1, axes) if axes > 1 else flat, fps, names, unit)


def read_obj(path: Path) -> NDArray[np.float32]:
    """Vertices (vertices, 3) of the lines of an OBJ file. Raises CorpusError."""
    try:
        rows = [line.split()[1:4] for line in read_utf8(path).splitlines() if line.startswith("v ")]
        return np.array(rows, np.float32).reshape(-1, 3)
    except (OSError, ValueError) as error:
        raise CorpusError(f"{path}: has no vertices ({error}); fetch it again") from error


def read_templates(
    folder: Path, scale: float = 1.0, name: str = "templates.pkl"
) -> dict[str, NDArray[np.float32]]:
    """Faces at rest by subject, (vertices, 3), of a pickle, if it is there. Raises CorpusError."""
    path = folder / name
    if not path.is_file():
        return {}
    tree = read_pickle(path)
    try:
        return {
            str(subject): np.asarray(points, np.float32).reshape(-1, 3) * np.float32(scale)
            for subject, points in tree.items()
        }
    except (AttributeError, TypeError, ValueError) as error:
        raise CorpusError(f"{path}: is not a set of faces by subject ({error}); fetch it again") from error
