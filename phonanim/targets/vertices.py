"""Vertices of a mesh: a row has their displacement from the subject's face at rest, or its components."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import CorpusError, ModelError
from phonanim.targets import Array, Clip, Floats, Source, TargetSettings

SAMPLED = 2000  # frames that principal components are fitted on, evenly spread over all
FAINT = 1e-7  # of the energy of the liveliest direction: less is rounding
REST, TRIANGLES = "rest of ", "triangles"  # of tensors


@dataclass(frozen=True, eq=False)
class Vertices:
    """Vertices of the mesh of a data set, in its unit.

    `templates` (vertices, 3) are faces at rest by subject. With `modes` (m, 3 vertices), which are
    orthonormal, a row has the components of displacement less `mean` (3 vertices,); without, all of it.
    `triangles` (n, 3) are rows of vertices, if known.
    """

    data: str
    unit: str
    templates: Mapping[str, Array]
    mean: Floats
    modes: Floats | None = None
    triangles: NDArray[np.int64] | None = None

    kind: ClassVar[str] = "vertices"

    @property
    def size(self) -> int:
        """Numbers in a row: components, or three for each vertex."""
        return len(self.mean) if self.modes is None else len(self.modes)

    @property
    def own_rest(self) -> Array:
        """The face that is animated where no subject is named: the mean of the templates."""
        return np.asarray(np.mean(list(self.templates.values()), axis=0))

    def rest_of(self, subject: str) -> Array:
        """The face at rest of a subject. Raises ModelError for one that is not known."""
        if subject not in self.templates:
            raise ModelError(f"the model has no face of {subject!r}; it has {', '.join(self.templates)}")
        return self.templates[subject]

    def rest_in_style(self, style: str) -> Array:
        """The face at rest of a style, which is a speaker, maybe with an emotion; else the mean of all."""
        of = (rest for name, rest in self.templates.items() if f"{style} ".startswith(f"{name} "))
        return next(of, self.own_rest)

    def encode(self, frames: NDArray[np.floating], rest: Array | None = None) -> Floats:
        """Rows, (frames, vertices, 3) -> (frames, size). Raises CorpusError for another mesh."""
        rest = self.own_rest if rest is None else rest
        if frames.shape[1:] != rest.shape:
            raise CorpusError(f"{self.data}: frames of {frames.shape[1:]}, and the face at rest {rest.shape}")
        moved = (frames - rest.astype(np.float32)).reshape(len(frames), -1).astype(np.float32)
        return moved if self.modes is None else np.asarray((moved - self.mean) @ self.modes.T, np.float32)

    def decode(self, rows: NDArray[np.floating], rest: Array | None = None) -> Floats:
        """Vertices of a subject, (frames, size) -> (frames, vertices, 3)."""
        rest = self.own_rest if rest is None else rest
        moved = rows if self.modes is None else rows @ self.modes + self.mean
        return np.asarray(moved.reshape(len(rows), -1, 3) + rest, np.float32)

    @classmethod
    def fit(cls, settings: TargetSettings, source: Source, clips: Iterable[Clip]) -> Vertices:
        """Fit principal components where asked. Raises CorpusError without faces at rest."""
        if not source.templates:
            raise CorpusError(f"{source.data}: has no faces at rest; build the corpus with --template")
        size = next(iter(source.templates.values())).size
        plain = cls(
            source.data, source.unit, source.templates, np.zeros(size, np.float32), None, source.triangles
        )
        if not settings.components:
            return plain
        mean, modes = components(sample_rows(plain, list(clips)), settings.components)
        return cls(source.data, source.unit, source.templates, mean, modes, source.triangles)

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Templates, components and triangles."""
        found: dict[str, NDArray[Any]] = {
            f"{REST}{name}": rest.astype(np.float32) for name, rest in self.templates.items()
        }
        if self.modes is not None:
            found |= {"mean": self.mean, "modes": self.modes}
        return found | ({} if self.triangles is None else {TRIANGLES: self.triangles.astype(np.int32)})

    def facts(self) -> dict[str, Any]:
        """The data set and the unit."""
        return {"data": self.data, "unit": self.unit}

    @classmethod
    def from_parts(cls, facts: Mapping[str, Any], tensors: Mapping[str, NDArray[Any]]) -> Vertices:
        """Raises KeyError or ValueError when the parts do not match."""
        rests = {
            name.removeprefix(REST): tensor.astype(np.float64)
            for name, tensor in tensors.items()
            if name.startswith(REST)
        }
        size = {rest.size for rest in rests.values() if rest.ndim == 2 and rest.shape[1] == 3}
        if len(size) != 1:
            raise ValueError("its faces at rest are not of one mesh")
        count = size.pop()
        modes = tensors["modes"].astype(np.float32) if "modes" in tensors else None
        mean = tensors["mean"].astype(np.float32) if modes is not None else np.zeros(count, np.float32)
        if mean.shape != (count,) or (modes is not None and modes.shape[1:] != (count,)):
            raise ValueError(f"its components are not of {count // 3} vertices")
        triangles = tensors[TRIANGLES].astype(np.int64) if TRIANGLES in tensors else None
        return cls(str(facts["data"]), str(facts["unit"]), rests, mean, modes, triangles)


def sample_rows(target: Vertices, clips: list[Clip]) -> Floats:
    """Displacements of frames evenly spread over clips, (SAMPLED at most, 3 vertices)."""
    total = sum(len(frames) for frames, _ in clips)
    every, first, found = max(1, -(-total // SAMPLED)), 0, []
    for frames, rest in clips:
        chosen = frames[first::every]
        if len(chosen):
            found.append(target.encode(np.asarray(chosen), rest))
        first = (first - len(frames)) % every
    return np.concatenate(found)


def components(rows: Floats, count: int) -> tuple[Floats, Floats]:
    """Mean (n,) and principal directions (count, n) of rows (samples, n), the most lively first.

    From the smaller Gram matrix, so that a mesh of any size takes little memory. Each sign makes the largest
    entry positive.
    """
    mean = rows.mean(axis=0, dtype=np.float64).astype(np.float32)
    centred = rows - mean
    energy, vectors = np.linalg.eigh((centred @ centred.T).astype(np.float64))
    kept = [place for place in np.argsort(-energy)[:count] if energy[place] > FAINT * energy.max()]
    if not kept:
        return mean, np.eye(1, rows.shape[1], dtype=np.float32)
    # Faint directions are not quite at right angles in single precision, so they are made so.
    modes = np.linalg.qr((vectors[:, kept].T.astype(np.float32) @ centred).T.astype(np.float64))[0].T
    largest = np.take_along_axis(modes, np.abs(modes).argmax(axis=1)[:, None], axis=1)
    return mean, np.asarray(np.where(largest < 0, -modes, modes), np.float32)


TARGET = Vertices
