"""Pamela lip sync (.pam), as Adventure Game Studio reads it: positions and phones of CMU."""

from __future__ import annotations

import re

from phonanim.readers._rows import from_starts
from phonanim.speech.alignment import Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "Pamela lip sync (.pam)"
FPS = 24.0
"""Frames per second. The file does not contain it; this is the default of Pamela."""

STEPS = 15
"""Positions in a frame."""

_SECTION = re.compile(r"^\[Speech\]\s*$(.*?)(?=^\[|\Z)", re.MULTILINE | re.DOTALL)
_ROW = re.compile(r"^[ \t]*(\d{1,9}):([A-Za-z]+\d?)\s*$", re.MULTILINE)


def recognizes(source: AlignmentFile) -> bool:
    """Whether there is a section of speech with a row of a position and a phone."""
    found = _SECTION.search(source.text[:20_000])
    return bool(found and _ROW.search(found[1]))


def read(source: AlignmentFile) -> Recording:
    """The phones, each until the next one; `None` is silence."""
    found = _SECTION.search(source.text)
    rows = _ROW.findall(found[1]) if found else []
    starts = sorted((int(place) / STEPS / FPS, "" if label == "None" else label) for place, label in rows)
    phones = from_starts(starts, starts[-1][0] + 1 / FPS)
    notes = (f"Pamela files have no frame rate; {FPS:g} fps assumed",)
    tier = Tier("phones", phones)
    return Recording((tier,), 0.0, phones[-1].end, notes, "english", unit=1 / STEPS / FPS)
