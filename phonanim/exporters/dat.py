"""Switch data for Moho (Anime Studio) and OpenToonz: the start frame of each mouth drawing."""

from __future__ import annotations

from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.core.files import write_text
from phonanim.exporters._cues import mouth_cues

SUMMARY = "Moho switch data: frame and Preston Blair mouth shape, 24 frames per second"
REST = "rest"


def write(animation: Animation, path: Path, frame_rate: float = 24.0) -> None:
    """Write one line per frame at which the shape changes, from frame 1. Raises OutputError.

    `frame_rate` is that of the Moho project. If several shapes begin in one frame, the last is kept.
    """
    cues = mouth_cues(animation, "preston_blair", path)
    frames = {1 + round(cue.start * frame_rate): cue.label for cue in cues}
    frames[max(1 + round(cues[-1].end * frame_rate), max(frames) + 1)] = REST
    lines = ["MohoSwitch1", *(f"{frame} {shape}" for frame, shape in frames.items())]
    write_text(path, "\n".join(lines) + "\n")
