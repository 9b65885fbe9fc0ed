"""Transcripts of NIST: RTTM with a row for each word, and STM with a row for each utterance."""

from __future__ import annotations

import re

from phonanim.readers._cues import cue_recording, plain_cue
from phonanim.readers._rows import lines, split
from phonanim.readers._words import TimedWord, word_recording
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "NIST transcripts (RTTM, STM)"

_TIME = r"(\d+(?:\.\d+)?)"
_WORD = re.compile(rf"LEXEME\s+\S+\s+\S+\s+{_TIME}\s+{_TIME}\s+(\S+)\s+\S+\s+(\S+)(?:\s+\S+){{0,2}}")
_UTTERANCE = re.compile(rf"\S+\s+(?:\d|[A-Z])\s+(\S+)\s+{_TIME}\s+{_TIME}\s+(?:<[^>]*>\s*)(.*)")


def recognizes(source: AlignmentFile) -> bool:
    """Whether there are rows of words, or the first row is an utterance with its label in angle brackets."""
    rows = _rows(source)[:50]
    return any(map(_WORD.fullmatch, rows)) or bool(rows and _UTTERANCE.fullmatch(rows[0]))


def read(source: AlignmentFile) -> Recording:
    """The words of each speaker; those of an utterance share its time by their letters."""
    rows = _rows(source)
    if words := [row for row in rows if row.startswith("LEXEME")]:
        matches = split(source, _WORD, words)
        found = [TimedWord(m[3], float(m[1]), float(m[1]) + float(m[2]), m[4]) for m in matches]
        return word_recording(found)
    matches = split(source, _UTTERANCE, rows)
    return cue_recording([plain_cue(float(m[2]), float(m[3]), m[4], m[1]) for m in matches])


def _rows(source: AlignmentFile) -> list[str]:
    """The rows that are no comments."""
    return [line for line in lines(source) if not line.startswith(";;")]
