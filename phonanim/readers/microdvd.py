"""Subtitles of MicroDVD (.sub), in frames, and MPL2, in tenths of a second."""

from __future__ import annotations

import re

from phonanim.readers._cues import cue_recording, plain_cue
from phonanim.readers._rows import all_match, split
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "MicroDVD and MPL2 subtitles"
FPS = 23.976
"""Frames per second where the file does not say: that of films for video."""

TENTH = 0.1  # seconds

_ROW = re.compile(r"(?:\{(\d{1,8})\}\{(\d{1,8})\}|\[(\d{1,8})\]\[(\d{1,8})\])(.*)")
_RATE = re.compile(r"(\d{2}(?:[.,]\d{1,3})?)(?:\s*fps)?", re.IGNORECASE)
_MARK = re.compile(r"\{[^{}]{0,100}\}")


def recognizes(source: AlignmentFile) -> bool:
    """Whether all rows begin with two whole numbers in brackets."""
    return bool(all_match(source, _ROW))


def read(source: AlignmentFile) -> Recording:
    """The words; those of a line share its time by their letters."""
    rows = split(source, _ROW)
    notes: tuple[str, ...] = ()
    if rows[0][3] is not None:
        unit = TENTH
    else:
        told = _RATE.fullmatch(rows[0][5].strip())
        unit = 1 / (float(told[1].replace(",", ".")) if told else FPS)
        notes = () if told else (f"the file has no frame rate; {FPS:g} fps assumed",)
        rows = rows[1:] if told else rows
    cues = [plain_cue(int(m[1] or m[3]) * unit, int(m[2] or m[4]) * unit, _plain(m[5])) for m in rows]
    return cue_recording(cues, notes=notes)


def _plain(text: str) -> str:
    """The text without its marks; a bar is a new line, and a slash begins one in italics."""
    return " ".join(line.lstrip("/") for line in _MARK.sub("", text).split("|"))
