"""Cues: lines of text with a start and an end, whose words may have times of their own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from phonanim.readers._words import SPREAD, TimedWord, check_count, spread_text, word_recording
from phonanim.speech.alignment import Recording
from phonanim.speech.intervals import ROUNDING

CUT = "lines overlap: each ends where the next one begins"


@dataclass(frozen=True, slots=True)
class Cue:
    """A line of text from `start` to `end` seconds: pieces of text, each with the time at which it begins."""

    start: float
    end: float
    pieces: tuple[tuple[float, str], ...]
    speaker: str = ""


def plain_cue(start: float, end: float, text: str, speaker: str = "") -> Cue:
    """A cue that times no piece of its text."""
    return Cue(start, end, ((start, text),), speaker)


def cue_recording(cues: Iterable[Cue], spoken: str = "", notes: tuple[str, ...] = ()) -> Recording:
    """The words; those of a piece share its time by their letters. Cues of a speaker are put in order."""
    ordered = sorted((cue for cue in cues if any(text.strip() for _, text in cue.pieces)), key=_begin)
    words: list[TimedWord] = []
    spread = cut = False
    for speaker in dict.fromkeys(cue.speaker for cue in ordered):
        apart, overlapped = _apart([cue for cue in ordered if cue.speaker == speaker])
        cut = cut or overlapped
        for cue in apart:
            found, shared = _words(cue)
            words += found
            check_count(words)
            spread = spread or shared
    told = (*notes, *((CUT,) if cut else ()), *((SPREAD,) if spread else ()))
    return word_recording(words, max((cue.end for cue in ordered), default=0.0), told, spoken=spoken)


def _begin(cue: Cue) -> float:
    return cue.start


def _apart(cues: Sequence[Cue]) -> tuple[list[Cue], bool]:
    """Cues that do not overlap, and whether they did: those with one start become one."""
    apart: list[Cue] = []
    cut = False
    for cue in cues:
        last = apart[-1] if apart else None
        if last is not None and last.end > cue.start + ROUNDING:
            cut = True
            if cue.start - last.start < ROUNDING:
                text = " ".join(piece for _, piece in (*last.pieces, *cue.pieces))
                apart[-1] = plain_cue(last.start, max(last.end, cue.end), text, cue.speaker)
                continue
            apart[-1] = replace(last, end=cue.start)
        apart.append(cue)
    return apart, cut


def _words(cue: Cue) -> tuple[list[TimedWord], bool]:
    """The words of a cue, and whether some of them share a time. A piece without a blank goes on a word."""
    words: list[TimedWord] = []
    shared, open_word = False, False
    ends = [*(time for time, _ in cue.pieces[1:]), cue.end]
    for (begin, text), end in zip(cue.pieces, ends, strict=True):
        begin, end = min(begin, cue.end), min(end, cue.end)
        spoken = spread_text(text, begin, max(begin, end), cue.speaker)
        if spoken and open_word and not text[:1].isspace():
            first = spoken.pop(0)
            words[-1] = TimedWord(words[-1].text + first.text, words[-1].start, first.end, cue.speaker)
        shared = shared or len(spoken) > 1
        words += spoken
        open_word = (open_word if not text.strip() else True) and not text[-1:].isspace() and bool(words)
    return words, shared
