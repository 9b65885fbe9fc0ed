"""Public data sets, read in their original layouts: one module each; its name is the data set's name.

Each module has `CARD`, the facts about the data set, and `recordings(folder)`, which uses only the names of
the files; motion and sound are loaded on demand. A name that begins with `_` is a helper.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from phonanim.core.plugins import Registry
from phonanim.errors import CorpusError, OptionError
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import Sound
from phonanim.speech.alignment import Interval

DATASETS = Registry("phonanim.datasets", needs=("CARD", "recordings"))

SPLITS = ("train", "validation", "test", "test_b", "")
"""`test_b` has speakers that are not in the training data; recordings without a split are unused there."""

KINDS = ("vertices", "controls", "sensors")


@dataclass(frozen=True)
class Frames:
    """Motion: `values` (frames, points, axes) of vertices and sensors, (frames, controls) of controls.

    `names` are those of the points or controls, empty if they are only numbered; `unit` is that of the
    values: "mm" if it is known, "as distributed" otherwise, and empty for controls.
    """

    values: NDArray[np.float32]
    fps: float
    names: tuple[str, ...] = ()
    unit: str = ""


@dataclass(frozen=True)
class Recording:
    """One recording of a data set; slow parts are functions without arguments.

    `sound` and `phones` are None if the data set has none; `phones` gives intervals in seconds. `emotion` is
    its name where the data set tells emotions apart.
    """

    name: str
    speaker: str
    split: str
    frames: Callable[[], Frames]
    sound: Callable[[], Sound] | None = None
    phones: Callable[[], tuple[Interval, ...]] | None = None
    text: str = ""
    emotion: str = ""


@dataclass(frozen=True)
class Card:
    """The facts about a data set: `kind` is one of KINDS; `assumed` lists what no publication gives."""

    title: str
    kind: str
    content: str
    licence: str
    ask: str
    layout: str
    split: str
    source: str
    assumed: str = ""


class Dataset(Protocol):
    """What a module of this folder, or a plugin of the group `phonanim.datasets`, offers."""

    CARD: Card

    def recordings(self, folder: Path) -> Iterator[Recording]:
        """The recordings in a folder, sorted by name. Raises CorpusError for another layout."""


def dataset_names() -> tuple[str, ...]:
    """The data sets, by the stem of their file."""
    return DATASETS.names()


def load_dataset(name: str) -> Dataset:
    """The module of one data set. Raises OptionError for an unknown name."""
    found = DATASETS.find(name)
    if found is None:
        raise OptionError(f"there is no data set {name!r}; there are {', '.join(dataset_names())}")
    return cast("Dataset", found)


def not_found(folder: Path, title: str, *looked_for: str) -> CorpusError:
    """An error that lists the files that a data set should have."""
    return CorpusError(f"{folder}: is not laid out as {title}; looked for {' or '.join(looked_for)}")


def intervals(path: Path) -> tuple[Interval, ...]:
    """The phones of an alignment file. Raises AlignmentError."""
    return read_alignment(path).intervals
