"""Lyrics (LRC): lines of text with the time at which they begin; enhanced ones time words too."""

from __future__ import annotations

import re
from collections.abc import Iterator

from phonanim.readers._cues import Cue, cue_recording
from phonanim.readers._rows import LONGEST_ROW, ROWS_LOOKED_AT, lines
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "lyrics (LRC)"
SLOWEST = 1.0  # seconds of a word in a line that is followed by a pause

_STAMP = re.compile(r"\[(\d{1,3}):(\d{1,2})(?:[.:](\d{1,3}))?\]")
_INNER = re.compile(r"<(\d{1,3}):(\d{1,2})(?:[.:](\d{1,3}))?>")
_ABOUT = re.compile(r"\[([a-z#]+):(.*)\]", re.IGNORECASE)


def recognizes(source: AlignmentFile) -> bool:
    """Whether all rows begin with a time in brackets, or say something about the song."""
    rows = [row for row in lines(source)[:ROWS_LOOKED_AT] if len(row) <= LONGEST_ROW]
    timed = [row for row in rows if _STAMP.match(row)]
    return bool(timed) and all(_STAMP.match(row) or _ABOUT.fullmatch(row) for row in rows)


def read(source: AlignmentFile) -> Recording:
    """The words. A line ends where the next one begins, or after a second a word at most."""
    told = {found[1]: found[2] for row in lines(source) if (found := _ABOUT.fullmatch(row))}
    earlier = _earlier(told)
    rows = sorted(_rows(source))
    cues: list[Cue] = []
    for (start, text), (following, _) in zip(rows, [*rows[1:], (float("inf"), "")], strict=True):
        end = min(following, start + SLOWEST * max(len(_INNER.sub(" ", text).split()), 1))
        inner = list(_INNER.finditer(text))
        if inner:
            pieces = ((_seconds(match), _after(text, match, inner)) for match in inner)
            timed = ((start, text[: inner[0].start()]), *pieces)
            last = _seconds(inner[-1]) if not _after(text, inner[-1], inner).strip() else min(end, following)
            end = max(last, _seconds(inner[-1]))
        else:
            timed = ((start, text),)
        moved = tuple((max(time - earlier, 0.0), piece) for time, piece in timed)
        cues.append(Cue(max(start - earlier, 0.0), max(end - earlier, 0.0), moved))
    notes = (f"times are {earlier * 1000:g} ms earlier, as the offset of the file says",) if earlier else ()
    return cue_recording(cues, told.get("la", ""), notes)


def _after(text: str, match: re.Match[str], inner: list[re.Match[str]]) -> str:
    following = next((one.start() for one in inner if one.start() >= match.end()), None)
    return text[match.end() : following]


def _rows(source: AlignmentFile) -> Iterator[tuple[float, str]]:
    """Start and text; a line that is sung several times has several times before it."""
    for row in lines(source):
        starts: list[float] = []
        while found := _STAMP.match(row):
            starts.append(_seconds(found))
            row = row[found.end() :]
        for start in starts:
            yield start, row


def _seconds(match: re.Match[str]) -> float:
    return int(match[1]) * 60 + int(match[2]) + float(f"0.{match[3] or 0}")


def _earlier(told: dict[str, str]) -> float:
    """Seconds by which the file asks to show its lines earlier; 0 where it does not."""
    try:
        return int(told.get("offset", "0").strip()) / 1000
    except ValueError:
        return 0.0
