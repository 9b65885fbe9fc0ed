"""Transcripts of CHAT (.cha), as CLAN and TalkBank have them: utterances, and words on the tier %wor."""

from __future__ import annotations

import re
from collections.abc import Iterator

from phonanim.readers._cues import Cue, cue_recording, plain_cue
from phonanim.readers._words import TimedWord, word_recording
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "CHAT transcripts (.cha)"
MILLISECOND = 1e-3

_BULLET = re.compile('\x15(?:%snd:"[^"]*"_)?(\\d{1,9})_(\\d{1,9})\x15')
_CODES = re.compile(r"\[[^\]\n]{0,200}\]|&[-+=~]?[^\s]*|[<>(){}+/\"“”‡„↑↓^]|\b0\w+|\bxxx\b|\byyy\b|\bwww\b")
_LANGUAGES = re.compile(r"^@Languages:\s*([a-z]{2,3})", re.MULTILINE)


def recognizes(source: AlignmentFile) -> bool:
    """Whether it begins as such a transcript does."""
    head = source.text[:2000]
    return "@Begin" in head and "\n*" in source.text


def read(source: AlignmentFile) -> Recording:
    """The words of each speaker: by the tier %wor, else those of an utterance share its time."""
    found = _LANGUAGES.search(source.text[:4000])
    spoken = found[1] if found else ""
    rows = list(_rows(source.text))
    if any(kind == "%wor" for kind, _, _ in rows):
        words = [word for kind, who, text in rows if kind == "%wor" for word in _words(text, who)]
        return word_recording(words, unit=MILLISECOND, spoken=spoken)
    cues = [cue for kind, who, text in rows if kind == "*" for cue in _cues(text, who)]
    if not cues:
        raise source.error("has no times; link it to its recording in CLAN")
    return cue_recording(cues, spoken)


def _rows(text: str) -> Iterator[tuple[str, str, str]]:
    """The kind of each tier, its speaker, and its text; a line that begins with a blank goes on."""
    speaker = ""
    for line in re.sub(r"\n[\t ]+", " ", text).split("\n"):
        name, _, rest = line.partition(":")
        if name.startswith("*"):
            speaker = name[1:]
            yield "*", speaker, rest
        elif name.startswith("%"):
            yield name, speaker, rest


def _words(text: str, speaker: str) -> Iterator[TimedWord]:
    parts = _BULLET.split(text)
    for word, start, end in zip(parts[::3], parts[1::3], parts[2::3], strict=False):
        if spoken := _plain(word):
            yield TimedWord(spoken, int(start) * MILLISECOND, int(end) * MILLISECOND, speaker)


def _cues(text: str, speaker: str) -> Iterator[Cue]:
    parts = _BULLET.split(text)
    for line, start, end in zip(parts[::3], parts[1::3], parts[2::3], strict=False):
        if spoken := _plain(line):
            yield plain_cue(int(start) * MILLISECOND, int(end) * MILLISECOND, spoken, speaker)


def _plain(text: str) -> str:
    """The text without the codes of the transcriber."""
    return " ".join(_CODES.sub(" ", text).split()).strip(" .?!,")
