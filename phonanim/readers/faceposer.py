"""Phonemes of Valve's Faceposer, as text: words and their phonemes with times in seconds."""

from __future__ import annotations

import re

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "phonemes of Faceposer (Source engine)"

_TIME = r"(-?\d+\.\d+)"
_WORD = re.compile(rf"^[ \t]*WORD\s+(\S+)\s+{_TIME}\s+{_TIME}\s*$", re.MULTILINE)
_PHONE = re.compile(rf"^[ \t]*\d+\s+(\S+)\s+{_TIME}\s+{_TIME}(?:\s+\S+)?\s*$", re.MULTILINE)


def recognizes(source: AlignmentFile) -> bool:
    """Whether it begins with a version and has a block of words."""
    return source.text.lstrip().startswith("VERSION") and bool(_WORD.search(source.text))


def read(source: AlignmentFile) -> Recording:
    """The words and their phonemes. Raises AlignmentError if there are no phonemes."""
    tiers = [
        Tier(name, tuple(Interval(label, float(start), float(end)) for label, start, end in rows), number)
        for number, (name, rows) in enumerate(
            (("words", _WORD.findall(source.text)), ("phones", _PHONE.findall(source.text))), 1
        )
    ]
    if not tiers[1].intervals:
        raise source.error("has words but no phonemes; extract them in Faceposer")
    end = max(one.end for tier in tiers for one in tier.intervals)
    return Recording(tuple(tiers), 0.0, end)
