"""Animations as phonanim writes them. Nothing here needs Blender."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FORMATS = (".json",)  # what is read here, tracks among them; phonanim turns everything else into it


class TakeError(ValueError):
    """A file that is no animation, or a program that did not do its work: one line for the user."""


@dataclass(frozen=True)
class Take:
    """One line: `curves` hold a value for each frame by channel, at `start + n / fps` seconds."""

    name: str
    document: dict[str, Any]

    @property
    def curves(self) -> dict[str, list[float]]:
        """The values of every channel."""
        return self.document["curves"]

    @property
    def times(self) -> list[float]:
        """The instant of each frame, seconds."""
        count = max(map(len, self.curves.values()), default=0)
        return [self.document["start"] + n / self.document["fps"] for n in range(count)]

    @property
    def phones(self) -> list[list[Any]]:
        """Label, start and end in seconds of each phone."""
        return self.document.get("phones") or []


def read_take(path: Path) -> Take:
    """Read phonanim's `.json` or an OpenFaceFX `.track.json`. Raises TakeError."""
    try:
        tree = json.loads(path.read_text("utf-8"))
        if tree["format"] == "openfacefx.track":
            tree = _dense(tree)
        elif tree["format"] != "phonanim animation 1":
            raise TakeError(f"{path}: its format is {tree['format']!r}")
        lengths = {len(curve) for curve in tree["curves"].values()}
        if len(lengths) != 1 or not tree["fps"] > 0 or tree["start"] is None:
            raise TakeError(f"{path}: has no curves of one length")
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, TakeError):
            raise
        raise TakeError(f"{path}: is not an animation of phonanim: {error!r}") from error
    return Take(path.name.removesuffix(".json").removesuffix(".track"), tree)


def _dense(track: dict[str, Any]) -> dict[str, Any]:
    """A track's keys at every frame."""
    fps = float(track["fps"])
    count = round(track["duration"] * fps) + 1
    curves = {one["name"]: [_value(one["keys"], n / fps) for n in range(count)] for one in track["channels"]}
    return {"format": "phonanim animation 1", "rig": "arkit", "fps": fps, "start": 0.0, "curves": curves}


def _value(keys: list[list[float]], time: float) -> float:
    """The value of keys at a time, straight between them and held outside."""
    before = [key for key in keys if key[0] <= time]
    after = [key for key in keys if key[0] > time]
    if not before or not after:
        return (before[-1] if before else after[0])[1]
    (t0, v0), (t1, v1) = before[-1], after[0]
    return v0 + (v1 - v0) * (time - t0) / (t1 - t0)
