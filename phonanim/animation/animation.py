"""Animation: curves of named channels over frames, and their provenance."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.speech.alignment import Interval

ROUNDING = 1e-6  # frames: an instant closer than this beyond the end counts as the end


@dataclass(frozen=True)
class Animation:
    """Control curves: `values[n]` holds every channel at the instant `start + n / fps` seconds.

    `values` is (frames, channels) float32; `channels` are the control names of `rig`;
    `phones` and `words` are the labels as spoken (for timelines); `audio` is the recording;
    `provenance` records its origin (input hash, model, rig, options, version);
    `articulation` (frames, CHANNELS of phonanim.articulation) mm is the motion of the mouth, if known.

    Examples:
        >>> import phonanim
        >>> animation = phonanim.animate("line.TextGrid", fps=30)
        >>> animation.values.shape == (len(animation.times), len(animation.channels))
        True
        >>> jaw = animation.channel("jawOpen")  # (frames,)
        >>> animation.save("line.csv")
    """

    values: NDArray[np.float32]
    channels: tuple[str, ...]
    fps: float
    rig: str
    start: float = 0.0
    phones: tuple[Interval, ...] = ()
    words: tuple[Interval, ...] = ()
    audio: Path | None = None
    provenance: dict[str, Any] = field(default_factory=dict)
    articulation: NDArray[np.float32] | None = None

    @property
    def times(self) -> NDArray[np.float64]:
        """(frames,) seconds."""
        return self.start + np.arange(len(self.values)) / self.fps

    def channel(self, name: str) -> NDArray[np.float32]:
        """The curve of one channel, (frames,). Raises KeyError when the rig has no such control."""
        if name not in self.channels:
            raise KeyError(name)
        return self.values[:, self.channels.index(name)]

    def at_rate(self, fps: float) -> Animation:
        """The same motion at another frame rate, by linear interpolation, from the same start."""
        count = int((len(self.values) - 1) * fps / self.fps + ROUNDING) + 1
        places = np.minimum(np.arange(count) * (self.fps / fps), len(self.values) - 1)
        first = np.minimum(places.astype(np.int64), max(len(self.values) - 2, 0))
        share = (places - first)[:, None].astype(np.float32)
        after = np.minimum(first + 1, len(self.values) - 1)

        def between(curves: NDArray[np.float32]) -> NDArray[np.float32]:
            return (1 - share) * curves[first] + share * curves[after]

        mouth = None if self.articulation is None else between(self.articulation)
        return replace(self, values=between(self.values), fps=fps, articulation=mouth)

    def save(self, path: str | Path, **options: Any) -> None:
        """Write the animation in the format of the path's suffix; the same as `phonanim.save`.

        Raises OutputError when there is no such format or the file cannot be written.
        """
        # The exporters import this module, so they are imported by name only when they are needed.
        import_module("phonanim.exporters").save(self, path, **options)

    def with_values(self, values: NDArray[np.float32]) -> Animation:
        """The same animation with new curves, (frames, channels)."""
        return replace(self, values=values)
