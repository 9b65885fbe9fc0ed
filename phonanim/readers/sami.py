"""SAMI subtitles (.smi): lines of text with the time at which they begin; an empty one ends the last."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator

from phonanim.readers._cues import Cue, cue_recording, plain_cue
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "SAMI subtitles"
LAST = 3.0  # seconds of a line that nothing ends
MILLISECOND = 1e-3
SHOWN = 5  # other languages that a note names

_SYNC = re.compile(r"<SYNC\b[^>]{0,100}?\bStart\s*=\s*[\"']?(\d{1,9})[^>]{0,100}>", re.IGNORECASE)
_CLASS = re.compile(r"<P\b[^>]{0,200}?\bClass\s*=\s*[\"']?([\w-]{1,40})[^>]{0,200}>", re.IGNORECASE)
_LANGUAGE = re.compile(r"\.([\w-]{1,40})\s*\{[^}]{0,400}?\blang:\s*([\w-]{2,20})", re.IGNORECASE)
_TAG = re.compile(r"<[^<>]{0,400}>")


def recognizes(source: AlignmentFile) -> bool:
    """Whether there is a mark of a SAMI document and a line with a start."""
    return "<sami" in source.text[:4000].lower() and bool(_SYNC.search(source.text))


def read(source: AlignmentFile) -> Recording:
    """The words of the first language; those of a line share its time by their letters."""
    languages = dict(_LANGUAGE.findall(source.text[:20_000]))
    first = _CLASS.search(source.text)
    wanted = first[1] if first else ""
    cues = [cue for cue in _cues(source.text, wanted) if cue.pieces[0][1].strip()]
    others = sorted({name for name in _CLASS.findall(source.text) if name != wanted})
    notes = (f"lines of {wanted} are read, those of {', '.join(others[:SHOWN])} are not",) if others else ()
    return cue_recording(cues, languages.get(wanted, ""), notes)


def _cues(text: str, wanted: str) -> Iterator[Cue]:
    found = list(_SYNC.finditer(text))
    shown = []
    for match, following in zip(found, [*found[1:], None], strict=True):
        body = text[match.end() : following.start() if following else None]
        kind = _CLASS.search(body)
        if not kind or kind[1] == wanted:
            plain = html.unescape(_TAG.sub(" ", body)).replace("\u00a0", " ")
            shown.append((int(match[1]) * MILLISECOND, " ".join(plain.split())))
    for (start, line), (end, _) in zip(shown, [*shown[1:], (shown[-1][0] + LAST, "")], strict=True):
        if end > start:
            yield plain_cue(start, end, line)
