"""The controls of Live Link Face, in the order of its files."""

from __future__ import annotations

from functools import cache

from phonanim.core.lexicon import LEXICON

N_ARKIT = 52  # the first columns; head and eye rotations follow, in radians in the file and in degrees here


@cache
def columns() -> tuple[str, ...]:
    """Control names in the order of the file, in Apple's spelling."""
    lines = (LEXICON / "formats" / "livelink.txt").read_text(encoding="utf-8").split("\n")
    return tuple(line[:1].lower() + line[1:] for line in lines if line and not line.startswith("#"))


@cache
def turns() -> tuple[str, ...]:
    """The controls that are rotations of head and eyes."""
    return columns()[N_ARKIT:]
