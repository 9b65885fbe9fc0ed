"""OpenFaceFX track: keys per channel; its exporters convert them for Unity, Godot, Live2D, Spine and more."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.animation.keys import Keys, reduce_channels
from phonanim.core.decode import DAMAGE, read_json
from phonanim.core.files import write_text
from phonanim.errors import OutputError
from phonanim.exporters._take import build_take, check_times, sample_curves, take_grid

SUMMARY = "OpenFaceFX track (version 1): straight keys per channel"
DIGITS = 4  # of times and values, as OpenFaceFX rounds them


def write(animation: Animation, path: Path, keys: float = 0.002) -> None:
    """Write keys whose interpolation error is at most `keys`; channels that stay at zero are left out.

    Raises OutputError when the destination cannot be written.
    """
    reduced = reduce_channels(animation, keys)
    channels = [
        {"name": name, "keys": _pairs(found, animation)}
        for name, found in reduced.items()
        if found.values.any()
    ]
    tree = {
        "format": "openfacefx.track",
        "version": 1,
        "fps": animation.fps,
        "duration": round(float(animation.times[-1]), DIGITS),
        "viseme_set": list(animation.channels),
        "channels": channels,
    }
    write_text(path, json.dumps(tree, ensure_ascii=False, indent=1) + "\n")


def read(path: Path) -> Animation:
    """Read a track at its frame rate, interpolated linearly. Raises OutputError for any other file."""
    try:
        tree = read_json(path)
        if tree["format"] != "openfacefx.track" or tree["version"] != 1:
            raise ValueError(f"its format is {tree['format']!r} version {tree['version']!r}")
        return _animation(tree, path)
    except (OSError, *DAMAGE) as error:
        raise OutputError(f"{path}: is not an OpenFaceFX track of version 1: {error}") from error


def _pairs(keys: Keys, animation: Animation) -> list[list[float]]:
    times = animation.times[keys.frames]
    return [
        [round(t, DIGITS), round(v, DIGITS)]
        for t, v in zip(times.tolist(), keys.values[:, 0].tolist(), strict=True)
    ]


def _animation(tree: dict[str, Any], path: Path) -> Animation:
    curves = {
        str(channel["name"]): np.array(channel["keys"], float).reshape(-1, 2) for channel in tree["channels"]
    }
    for name, curve in curves.items():
        check_times(curve[:, 0], name)
    names = list(dict.fromkeys([*map(str, tree.get("viseme_set") or []), *curves]))
    grid = take_grid(0.0, max(curve[-1, 0] for curve in curves.values()), tree["fps"], len(names), path)
    still = np.zeros((1, 2))
    values = sample_curves(grid, [tuple(curves.get(name, still).T) for name in names])
    return build_take(values, names, tree["fps"], 0.0, {"provenance": {"input": path.name}}, path)
