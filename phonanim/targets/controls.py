"""Controls of a rig, such as blendshapes: a row has those that move in the training clips, scaled."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.targets import Array, Clip, Floats, Source, TargetSettings
from phonanim.targets._moments import as_single, moments_of


@dataclass(frozen=True, eq=False)
class Controls:
    """Controls of the rig of a data set, `names` (controls,).

    A row has (value - `low`) / `span` of the controls in `moving` (controls,); the others keep `low`.
    Decoded values stay within `least` and `most` (controls,), if there are limits.
    """

    data: str
    names: tuple[str, ...]
    moving: NDArray[np.bool_]
    low: Floats
    span: Floats
    least: Floats | None = None
    most: Floats | None = None

    kind: ClassVar[str] = "controls"

    @property
    def size(self) -> int:
        """Controls that move."""
        return int(self.moving.sum())

    def encode(self, frames: NDArray[np.floating], rest: Array | None = None) -> Floats:
        """Rows, (frames, controls) -> (frames, size)."""
        return np.asarray(((frames - self.low) / self.span)[:, self.moving], np.float32)

    def decode(self, rows: NDArray[np.floating], rest: Array | None = None) -> Floats:
        """Controls within their limits, (frames, size) -> (frames, controls)."""
        values = np.tile(self.low, (len(rows), 1))
        values[:, self.moving] += rows * self.span[self.moving]
        return np.asarray(np.clip(values, self.least, self.most), np.float32) if self._limited else values

    @property
    def _limited(self) -> bool:
        return self.least is not None and self.most is not None

    @classmethod
    def fit(cls, settings: TargetSettings, source: Source, clips: Iterable[Clip]) -> Controls:
        """Learn ranges or moments. Raises CorpusError when nothing moves in the clips."""
        found = moments_of(clips, source.data)
        low, span = found.scaling(settings)
        names = source.names or tuple(map(str, range(len(low))))
        if settings.limits == "none":
            return cls(source.data, names, found.moving, low, span)
        unit = found.least.min() >= 0 and found.most.max() <= 1
        least = np.zeros_like(low) if unit else as_single(found.least)
        most = np.ones_like(low) if unit else as_single(found.most)
        return cls(source.data, names, found.moving, low, span, least, most)

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Scaling and limits."""
        found: dict[str, NDArray[Any]] = {"moving": self.moving.astype(np.uint8)}
        found |= {"low": self.low, "span": self.span}
        return found | {n: v for n, v in (("least", self.least), ("most", self.most)) if v is not None}

    def facts(self) -> dict[str, Any]:
        """The names of the controls, and the data set."""
        return {"data": self.data, "names": list(self.names)}

    @classmethod
    def from_parts(cls, facts: Mapping[str, Any], tensors: Mapping[str, NDArray[Any]]) -> Controls:
        """Raises KeyError or ValueError when the parts do not match."""
        names = tuple(map(str, facts["names"]))
        if any(tensor.shape != (len(names),) for tensor in tensors.values()):
            raise ValueError(f"its tensors are not of {len(names)} controls")
        real = {name: tensor.astype(np.float32) for name, tensor in tensors.items()}
        moving = tensors["moving"].astype(bool)
        limits = real.get("least"), real.get("most")
        return cls(str(facts["data"]), names, moving, real["low"], real["span"], *limits)


TARGET = Controls
