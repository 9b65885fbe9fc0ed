"""The rig of each format of a line: the line's own, or the one that the format needs."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from phonanim.dubbing.line import Line
from phonanim.exporters import needed_rig
from phonanim.pipeline import load_cached_rig


def rigs_of_formats(line: Line, formats: tuple[str, ...]) -> dict[str, str]:
    """The rig of each format. Raises RigError where the line's own cannot be read."""
    has_character = "character" in line.exports
    return {suffix: rig_of_format(line.options.rig, suffix, has_character) for suffix in formats}


@cache
def rig_of_format(rig: str, suffix: str, has_character: bool) -> str:
    """The rig of one format, for a line of this rig."""
    controls = load_cached_rig(rig).controls
    return needed_rig(Path(f"line.{suffix}"), controls, has_character) or rig
