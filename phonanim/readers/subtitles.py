"""Subtitles, SRT and WebVTT: lines of text with clock times; WebVTT may time single words."""

from __future__ import annotations

import re
from collections.abc import Iterator

from phonanim.readers._times import clock_seconds
from phonanim.readers._words import SPREAD, TimedWord, spread_text, word_recording
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "subtitles (SRT, WebVTT)"

_TIME = r"(?:\d{1,4}:)?\d{1,2}:\d{1,2}[.,]\d{1,6}"
_CUE = re.compile(rf"^[ \t]*({_TIME})[ \t]+-->[ \t]+({_TIME}).*$", re.MULTILINE)
_INNER = re.compile(rf"<({_TIME})>")
_VOICE = re.compile(r"<v(?:\.[^ >]*)? ([^>]*)>")
_TAG = re.compile(r"<[^>]*>|\{\\?[^}]*\}")
_ENTITIES = {"&amp;": "&", "&lt;": "<", "&gt;": ">", "&nbsp;": " ", "&lrm;": "", "&rlm;": ""}


def recognizes(source: AlignmentFile) -> bool:
    """Whether there is a line of two clock times with an arrow between them near the beginning."""
    return bool(_CUE.search(source.text[:4000]))


def read(source: AlignmentFile) -> Recording:
    """The words; those of a line share its time by their letters, but where they have times of their own."""
    words: list[TimedWord] = []
    spread = False
    end = 0.0
    for start, last, text in _cues(source):
        voice = found[1].strip() if (found := _VOICE.search(text)) else ""
        pieces = _INNER.split(text)
        times = [start, *map(clock_seconds, pieces[1::2]), last]
        for piece, begin, stop in zip(pieces[::2], times, times[1:], strict=False):
            spoken = spread_text(_plain(piece), begin, stop, voice)
            spread = spread or len(spoken) > 1
            words += spoken
        end = max(end, last)
    return word_recording(words, end, (SPREAD,) if spread else ())


def _cues(source: AlignmentFile) -> Iterator[tuple[float, float, str]]:
    """Start, end and text of each cue; its text ends at an empty line."""
    found = list(_CUE.finditer(source.text))
    for match, following in zip(found, [*found[1:], None], strict=True):
        text = source.text[match.end() : following.start() if following else None]
        yield clock_seconds(match[1]), clock_seconds(match[2]), text.strip("\n").split("\n\n")[0]


def _plain(text: str) -> str:
    """The text without its marks, and without the dash of a new speaker."""
    text = re.sub(r"^\s*-\s*", "", _TAG.sub("", text), flags=re.MULTILINE)
    for entity, character in _ENTITIES.items():
        text = text.replace(entity, character)
    return text
