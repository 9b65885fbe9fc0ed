"""Subtitles, SRT, WebVTT and SBV: lines of text with clock times; WebVTT may time single words."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

from phonanim.readers._cues import Cue, cue_recording
from phonanim.readers._highlights import StyledCue, spoken_words
from phonanim.readers._times import clock_seconds
from phonanim.readers._words import split_speaker
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "subtitles (SRT, WebVTT, SBV)"
REPEATED = "a line that a cue repeats from the one before it is read once"

_TIME = r"(?:\d{1,4}:)?\d{1,2}:\d{1,2}[.,]\d{1,6}"
_CUE = re.compile(rf"^[ \t]*({_TIME})(?:[ \t]+-->[ \t]+|,(?={_TIME}\s*$))({_TIME}).*$", re.MULTILINE)
_PRINTED = re.compile(rf"^[ \t]*\[({_TIME})[ \t]+-->[ \t]+({_TIME})\][ \t]*(.*)$", re.MULTILINE)
"""A line as Whisper prints it."""

_INNER = re.compile(rf"<({_TIME})>")
_STYLE = re.compile(r"<(/?(?:u|b|i|em|strong|font|c)\b[^>]{0,200})>")
_VOICE = re.compile(r"<v(?:\.[^ <>]*)? ([^<>]*)>")
_LANGUAGE = re.compile(r"WEBVTT[^\n]*(?:\n[^\n]+)*?\nLanguage:\s*(\S+)")
_TAG = re.compile(r"<[^<>]*>|\{\\?[^{}]*\}")
_ENTITIES = {"&amp;": "&", "&lt;": "<", "&gt;": ">", "&nbsp;": " ", "&lrm;": "", "&rlm;": ""}


@dataclass(frozen=True, slots=True)
class _Shown:
    """The lines of a cue as the file has them."""

    start: float
    end: float
    lines: tuple[str, ...]


def recognizes(source: AlignmentFile) -> bool:
    """Whether there is a line of two clock times near the beginning."""
    head = source.text[:4000]
    return bool(_CUE.search(head) or _PRINTED.search(head))


def read(source: AlignmentFile) -> Recording:
    """The words; those of a line share its time by their letters, but where they have times of their own."""
    shown = _without_marked(list(_shown(source)))
    rolls = _rolls(shown)
    cues = _with_speakers([_cue(one) for one in (_once(shown) if rolls else shown)])
    found = _LANGUAGE.match(source.text[:400])
    return cue_recording(cues, found[1] if found else "", (REPEATED,) if rolls else ())


def _shown(source: AlignmentFile) -> Iterator[_Shown]:
    """Start, end and lines of each cue; its text ends at an empty line."""
    content = _PRINTED.sub(r"\n\1 --> \2\n\3\n", source.text)
    found = list(_CUE.finditer(content))
    for match, following in zip(found, [*found[1:], None], strict=True):
        text = content[match.end() : following.start() if following else None]
        lines = text.strip("\n").split("\n\n")[0].split("\n")
        if following and "\n\n" not in text.strip("\n") and len(lines) > 1 and lines[-1].strip().isdecimal():
            lines = lines[:-1]  # the number of the next cue, which no empty line separates
        spoken = tuple(line for line in lines if _plain(line).strip())
        yield _Shown(clock_seconds(match[1]), clock_seconds(match[2]), spoken)


def _without_marked(shown: list[_Shown]) -> list[_Shown]:
    """The cues; where a line is shown once for each word with that word marked, the marked words."""
    whole = ["\n".join(one.lines) for one in shown]
    if not any(_STYLE.search(text) for text in whole) or any(map(_INNER.search, whole)):
        return shown
    styled = [StyledCue(one.start, one.end, _runs(text)) for one, text in zip(shown, whole, strict=True)]
    found = spoken_words(styled)
    if found == styled:
        return shown
    return [_Shown(one.start, one.end, ("".join(text for _, text in one.runs),)) for one in found]


def _runs(text: str) -> tuple[tuple[str, str], ...]:
    """The text of a cue by its styles."""
    parts = _STYLE.split(text)
    styles = ["", *("" if tag.startswith("/") else tag for tag in parts[1::2])]
    return tuple((style, _plain(part)) for style, part in zip(styles, parts[::2], strict=True) if part)


def _with_speakers(cues: list[Cue]) -> list[Cue]:
    """The cues without the names of speakers before their text, which are used where every cue has one."""
    named = [(cue, *split_speaker(cue.pieces[0][1])) for cue in cues if cue.pieces]
    every = all(speaker for _, speaker, _ in named)
    return [
        replace(
            cue,
            pieces=((cue.pieces[0][0], text), *cue.pieces[1:]),
            speaker=cue.speaker or (speaker if every else ""),
        )
        for cue, speaker, text in named
    ]


def _rolls(shown: list[_Shown]) -> bool:
    """Whether lines roll up, as in captions made live: most cues begin with what the one before it shows."""
    pairs = [(a, b) for a, b in pairwise(one for one in shown if one.lines) if _new_lines(a, b) != b.lines]
    return 2 * len(pairs) >= len(shown) - 1 and any(_new_lines(a, b) for a, b in pairs)


def _once(shown: list[_Shown]) -> Iterator[_Shown]:
    """The cues with the lines that the one before does not show."""
    last: _Shown | None = None
    for one in shown:
        if not one.lines:
            continue
        new = _new_lines(last, one) if last else one.lines
        last = one
        if new:
            yield _Shown(one.start, one.end, new)


def _new_lines(before: _Shown, after: _Shown) -> tuple[str, ...]:
    """The lines of a cue without those at its beginning with which the cue before it ends."""
    old = [_plain(line).split() for line in before.lines]
    new = [_plain(line).split() for line in after.lines]
    for count in range(min(len(old), len(new)), 0, -1):
        if old[-count:] == new[:count]:
            return after.lines[count:]
    return after.lines


def _cue(shown: _Shown) -> Cue:
    text = "\n".join(shown.lines)
    voice = found[1].strip() if (found := _VOICE.search(text)) else ""
    pieces = _INNER.split(text)
    times = [shown.start, *map(clock_seconds, pieces[1::2])]
    timed = zip(times, map(_plain, pieces[::2]), strict=True)
    return Cue(shown.start, shown.end, tuple(timed), voice)


def _plain(text: str) -> str:
    """The text without its marks, and without the dash of a new speaker."""
    text = re.sub(r"\[br\]|<br\s*/?>", " ", text)  # of SubViewer
    text = re.sub(r"^[ \t]*-\s+|^-(?=\w)", "", _TAG.sub("", text), flags=re.MULTILINE)
    for entity, character in _ENTITIES.items():
        text = text.replace(entity, character)
    return text
