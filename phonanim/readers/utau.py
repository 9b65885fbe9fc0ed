"""UTAU (.ust): notes with their lyrics, one after another; the length is in ticks of a tempo."""

from __future__ import annotations

import math
import re

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "UTAU (.ust)"
TICKS = 480
"""Ticks in a quarter note."""

NOTE = "the lyrics of notes are read as sounds; vowels are held for the whole note"

_BLOCK = re.compile(r"^\[#(\w+)\]\s*$", re.MULTILINE)
_RESTS = ("r", "rest", "")


def recognizes(source: AlignmentFile) -> bool:
    """Whether it has the settings of a project and notes."""
    return "[#SETTING]" in source.text[:2000] and "[#0000]" in source.text[:20_000]


def read(source: AlignmentFile) -> Recording:
    """The lyrics at their notes, in UTAU's kana or romanization; R is a rest."""
    blocks = _BLOCK.split(source.text)
    tempo, time = 120.0, 0.0
    notes: list[Interval] = []
    try:
        for name, body in zip(blocks[1::2], blocks[2::2], strict=True):
            cells = dict(line.split("=", 1) for line in body.splitlines() if "=" in line)
            tempo = _positive(cells["Tempo"].replace(",", ".")) if cells.get("Tempo") else tempo
            if name.isdigit():
                length = _positive(cells["Length"]) / TICKS * 60 / tempo
                lyric = cells.get("Lyric", "").strip().rpartition(" ")[2].lstrip("?")
                label = "" if lyric.lower() in _RESTS else lyric
                notes.append(Interval(label, time, time + length))
                time += length
    except DAMAGE as error:
        raise source.error(f"has a damaged note ({error!r}); save it again") from error
    return Recording((Tier("phones", tuple(notes)),), 0.0, time, (NOTE,))


def _positive(text: str) -> float:
    value = float(text)
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{text[:20]!r} is not above 0")
    return value
