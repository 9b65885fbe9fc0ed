"""Songs of UltraStar (.txt): syllables with their beats."""

from __future__ import annotations

import re
from typing import NamedTuple

from phonanim.readers._words import TimedWord, word_recording
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile, quote_label

FORMAT = "UltraStar songs"
BEATS = 4
"""The file counts quarters of the beats of its #BPM."""

_HEAD = re.compile(r"^#([A-Z0-9]+):(.*)$", re.MULTILINE)
_NOTE = re.compile(r"[:*FRG] +(-?\d{1,9}) +(\d{1,9}) +-?\d+ ?(.*)")
_REST = re.compile(r"-|- *-?\d|E\s*$|P ?\d|B ")
HELD = ("~", "-")
"""What is written for a syllable that is held."""


class _Note(NamedTuple):
    start: float
    end: float
    text: str


def recognizes(source: AlignmentFile) -> bool:
    """Whether there is a header with #BPM, and a note."""
    head = dict(_HEAD.findall(source.text[:4000]))
    return "BPM" in head and any(map(_NOTE.fullmatch, source.text.splitlines()[: len(head) + 20]))


def read(source: AlignmentFile) -> Recording:
    """The words of the song: syllables, of which one that opens a word begins or follows with a blank."""
    head = {name: value.strip() for name, value in _HEAD.findall(source.text)}
    try:
        beat = 60.0 / float(head["BPM"].replace(",", ".")) / BEATS
        gap = float(head.get("GAP", "0").replace(",", ".") or 0) / 1000
    except (ValueError, ZeroDivisionError) as error:
        raise source.error('has a damaged "#BPM" or "#GAP"; save it again') from error
    words: list[TimedWord] = []
    fresh, line = True, 0.0
    for row in source.text.splitlines():
        if match := _NOTE.fullmatch(row):
            start = gap + (line + int(match[1])) * beat
            _add(words, _Note(start, start + int(match[2]) * beat, match[3]), fresh)
            fresh = match[3].endswith(" ")
        elif _REST.match(row):
            fresh = True
            found = re.fullmatch(r"- *(-?\d{1,9})(?: +(-?\d{1,9}))?\s*", row)
            if found and head.get("RELATIVE", "").lower() == "yes":
                line += int(found[2] or found[1])
        elif row.strip() and not row.startswith("#"):
            raise source.error(f'has a damaged row "{quote_label(row)}"; save it again')
    return word_recording(words, spoken=head.get("LANGUAGE", ""))


def _add(words: list[TimedWord], note: _Note, fresh: bool) -> None:
    """Add a syllable: to the last word, or as a new one."""
    text = note.text.strip()
    held = text.strip("".join(HELD)) == ""
    if words and (held or not (fresh or note.text.startswith(" "))):
        last = words[-1]
        words[-1] = TimedWord(last.text + ("" if held else text.strip("~")), last.start, note.end)
    elif not held:
        words.append(TimedWord(text.strip("~"), note.start, note.end))
