"""Audio2Face's JSON of blend shape weights: what its files hold, read and written by their own names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.core.decode import DecodeError, decode_list, decode_rate, decode_text
from phonanim.exporters._frames import frames_from_zero
from phonanim.exporters._take import build_take, check_size
from phonanim.rig.neck import is_turn

DIGITS = 6


def is_audio2face(tree: Any) -> bool:
    """Whether JSON has the entries of Audio2Face."""
    return isinstance(tree, dict) and {"facsNames", "weightMat"} <= set(tree)


def to_audio2face(animation: Animation) -> dict[str, Any]:
    """A row of weights for each frame from time zero on; turns of the head have no place."""
    columns = [n for n, name in enumerate(animation.channels) if not is_turn(name)]
    weights = frames_from_zero(animation, animation.fps)[:, columns]
    fps = animation.fps
    return {
        "exportFps": int(fps) if fps == int(fps) else fps,
        "trackPath": animation.audio.name if animation.audio else "",
        "numPoses": len(columns),
        "numFrames": len(weights),
        "facsNames": [animation.channels[n] for n in columns],
        "weightMat": np.round(weights.astype(float), DIGITS).tolist(),
    }


def from_audio2face(tree: Any, path: Path) -> Animation:
    """The inverse of `to_audio2face`. Raises DecodeError and what damaged data raise."""
    names = [decode_text(name, "a name in facsNames") for name in decode_list(tree["facsNames"], "facsNames")]
    rows = decode_list(tree["weightMat"], "weightMat")
    check_size(len(rows), len(names), path)
    for number, row in enumerate(rows):
        if len(decode_list(row, f"weightMat[{number}]")) != len(names):
            raise DecodeError(f"weightMat[{number}] has {len(row)} weights for {len(names)} names")
    values = np.asarray(rows, np.float64).reshape(len(rows), len(names))
    fps = decode_rate(tree.get("exportFps", 60), "exportFps")
    return build_take(values, names, fps, 0.0, {"provenance": {"input": path.name}}, path)
