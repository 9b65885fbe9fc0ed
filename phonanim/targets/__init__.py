"""Target spaces: what a frame of a corpus is, as rows of numbers that a regressor learns, and back.

One file for each kind; the file's stem is the kind. Landmarks are those of the reference face, which moves
any rig. Controls, sensors and vertices are those of a data set, as `phonanim corpus build` lays them out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from phonanim.core.plugins import Registry
from phonanim.errors import ModelError

TARGETS = Registry("phonanim.targets", needs=("TARGET",))

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Clip = tuple[NDArray[np.floating], Array | None]
"""Frames of a recording, (frames, ...), and its subject at rest, if it has one: a face (vertices, 3), or the
mean position of sensors (sensors, 3)."""


@dataclass(frozen=True)
class TargetSettings:
    """How a corpus becomes rows, [target] of a recipe; everything is fitted on the training clips alone.

    `scale` is that of controls and sensors: each to 0..1, each to mean 0 and deviation 1, or as they are.
    `limits` bounds the controls of a prediction: by 0 and 1 where all training frames are within, else by the
    least and greatest that occur; "none" for no bounds. `components` is the number of principal components of
    vertices; 0 learns every coordinate. `styles` are what a model that has styles tells apart.
    """

    scale: Literal["minmax", "zscore", "none"] = "minmax"
    limits: Literal["data", "none"] = "data"
    components: int = 0
    styles: Literal["none", "speaker", "emotion", "speaker and emotion"] = "speaker"


@dataclass(frozen=True)
class Source:
    """What is known of the frames of a corpus.

    `data` is the data set's name, `names` are those of controls or sensors, `unit` is "mm" or empty.
    `templates` are subjects at rest by name: faces (vertices, 3), or mean positions of sensors (sensors, 3).
    `triangles` (n, 3) are rows of vertices, if known.
    """

    data: str
    names: tuple[str, ...] = ()
    unit: str = ""
    templates: Mapping[str, Array] = field(default_factory=dict)
    triangles: NDArray[np.int64] | None = None


class Target(Protocol):
    """What a model moves. `rest` is the subject at rest, (vertices, 3) or (sensors, 3)."""

    kind: ClassVar[str]

    @property
    def size(self) -> int:
        """Numbers in a row."""

    def encode(self, frames: NDArray[np.floating], rest: Array | None = None) -> Floats:
        """Rows to learn, (frames, ...) -> (frames, size)."""

    def decode(self, rows: NDArray[np.floating], rest: Array | None = None) -> NDArray[np.floating]:
        """Frames in the corpus' unit, (frames, size) -> (frames, ...)."""


class StoredTarget(Target, Protocol):
    """A target that is learned from a corpus and stored as target.safetensors and in model.json."""

    @classmethod
    def fit(cls, settings: TargetSettings, source: Source, clips: Iterable[Clip]) -> StoredTarget:
        """Learn scaling from training clips. Raises CorpusError when nothing moves in them."""

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Arrays by name."""

    def facts(self) -> dict[str, Any]:
        """The rest, as JSON."""

    @classmethod
    def from_parts(cls, facts: Mapping[str, Any], tensors: Mapping[str, NDArray[Any]]) -> StoredTarget:
        """The target that `tensors` and `facts` describe. Raises KeyError or ValueError."""


def target_class(kind: str) -> type[StoredTarget]:
    """The class of a kind. Raises ModelError, which suggests the nearest name."""
    found = TARGETS.find(kind)
    if found is None:
        near = get_close_matches(kind, TARGETS.names(), n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise ModelError(f"there is no target {kind!r}{hint} (known: {', '.join(TARGETS.names())})")
    target: type[StoredTarget] = found.TARGET
    return target
