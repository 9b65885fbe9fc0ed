"""Rhubarb Lip Sync TSV: the start of each mouth shape."""

from __future__ import annotations

from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.core.files import write_text
from phonanim.exporters._cues import mouth_cues

SUMMARY = "Rhubarb Lip Sync cues, tab-separated: start in seconds, shape A to H or X"


def write(animation: Animation, path: Path) -> None:
    """Write one line per cue, and a closed mouth at the end. Raises OutputError."""
    cues = mouth_cues(animation, "rhubarb", path)
    lines = [f"{cue.start:.2f}\t{cue.label}" for cue in cues]
    write_text(path, "\n".join([*lines, f"{cues[-1].end:.2f}\tX"]) + "\n")
