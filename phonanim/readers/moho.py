"""Switch data of Moho (.dat), as exported by Papagayo and Rhubarb: frame and mouth shape."""

from __future__ import annotations

import re

from phonanim.readers._rows import from_starts, lines, split
from phonanim.readers._shapes import shape_phones
from phonanim.speech.alignment import Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "Moho switch data"
FPS = 24.0
"""Frames per second. The file does not contain it; this is the default of Papagayo, Rhubarb and Moho."""

_ROW = re.compile(r"(\d+)\s+(\S+)")


def recognizes(source: AlignmentFile) -> bool:
    """Whether the first line is that of switch data."""
    return source.text.lstrip().startswith("MohoSwitch1")


def read(source: AlignmentFile) -> Recording:
    """The shapes as phones, in the set of mouth shapes or phones that they are of."""
    rows = split(source, _ROW, lines(source)[1:])
    if not rows:
        raise source.error("has no frames; export it again")
    starts = [((float(row[1]) - 1) / FPS, row[2]) for row in rows]
    phones, language, notes = shape_phones(from_starts(starts, starts[-1][0] + 1 / FPS))
    notes = (f"switch data has no frame rate; {FPS:g} fps assumed", *notes)
    return Recording((Tier("phones", phones),), 0.0, phones[-1].end, notes, language, 1 / FPS)
