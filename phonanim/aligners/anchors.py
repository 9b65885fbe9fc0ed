"""Align long recordings: hear words freely, match them with the text, and align between quiet places.

The recording is cut where it is quiet into windows of at most 30 s, whose words Whisper hears. Where these
match the text is known which words each window has; they are aligned in it. What was not heard is left
out, so that a text with some wrong words does no harm, and windows without words of the text are skipped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.aligners._matching import Pairs, match_words
from phonanim.aligners.espeak import VOICE, can_speak, speak
from phonanim.aligners.pocketsphinx import FORGIVEN, PieceAligner, SpeechAlignment, split_words
from phonanim.aligners.warping import phones_along, warp, words_along
from phonanim.aligners.whisper import RATE, hear, quiet_windows
from phonanim.errors import AlignmentError, PhonanimError
from phonanim.media.audio import Sound, read_sound, resample
from phonanim.speech.alignment import Interval
from phonanim.speech.spoken_words import split_word

LEAST = 0.3  # share of a text that must be heard
CLEAR = 0.6  # share of a window's words below which it is doubtful
DROPPED = 2  # words in a row where nothing at all was heard, from which they count as not spoken
MOST_SHOWN = 5


@dataclass
class _Window:
    """A part of a recording: its samples from `begin` to `end`, words of the text, and the share heard."""

    begin: int
    end: int
    words: list[str]
    heard: float = 1.0


def align_by_anchors(audio: Path, text: str) -> SpeechAlignment:
    """Find the words and phones of an English text in a recording of any length; for long ones.

    Notes tell what was left out or is doubtful. Raises AlignmentError when less than a third of the text is
    heard, MissingExtraError without the extras `recognize` and `align`.
    """
    sound = read_sound(audio)
    samples = resample(sound.samples, sound.rate, RATE)
    spans = quiet_windows(samples)
    words = split_words(text)
    heard = [_parts(split_words(hear(samples[begin:end]))) for begin, end in spans]
    windows, lost = _shared(words, heard, spans, str(audio))
    words_found: list[Interval] = []
    phones: list[Interval] = []
    notes: list[str] = []
    aligner = PieceAligner()
    for window in windows:
        if window.words:
            found = _aligned(aligner, samples, window)
            if found is None:
                notes.append(f"the words of {_span(window)} are not found in it: {_some(window.words)}")
                continue
            words_found += _moved(found.words, window)
            phones += _moved(found.phones, window)
    notes += _notes(windows, lost)
    if not words_found:
        raise AlignmentError(f"{audio}: the text cannot be found in the audio; check that they match")
    return SpeechAlignment(tuple(words_found), tuple(phones), sound.duration, (*aligner.notes(), *notes))


def _parts(words: Sequence[str]) -> list[str]:
    return [part for word in words for part in split_word(word)]


def _shared(
    words: Sequence[str], heard: Sequence[Sequence[str]], spans: Sequence[tuple[int, int]], name: str
) -> tuple[list[_Window], list[str]]:
    """The windows with the words of the text that each has, and the words that are in none."""
    owners = [(part, number) for number, word in enumerate(words) for part in split_word(word)]
    parts = [part for part, _ in owners]
    flat = [(part, number) for number, window in enumerate(heard) for part in window]
    pairs = match_words(parts, [part for part, _ in flat])
    if len(pairs) < LEAST * len(parts):
        share = len(pairs) / max(len(parts), 1)
        raise AlignmentError(f"{name}: only {share:.0%} of the text is heard in it; check that they match")
    places = _places(pairs, len(parts), [number for _, number in flat])
    windows = [_Window(begin, end, []) for begin, end in spans]
    matched = {i for i, _ in pairs}
    known = [[0, 0] for _ in spans]
    lost: list[str] = []
    done: set[int] = set()
    for place, (_, owner) in zip(places, owners, strict=True):
        if place is not None and owner not in done:
            windows[place].words.append(words[owner])
            done.add(owner)
    for part, (place, (_, owner)) in enumerate(zip(places, owners, strict=True)):
        if place is None and owner not in done:
            lost.append(words[owner])
            done.add(owner)
        elif place is not None:
            known[place][0] += part in matched
            known[place][1] += 1
    for window, (right, count) in zip(windows, known, strict=True):
        window.heard = right / count if count else 1.0
    return windows, lost


def _places(pairs: Pairs, count: int, windows: Sequence[int]) -> list[int | None]:
    """The window of each part of the text; None for one that was not spoken."""
    places: list[int | None] = [None] * count
    last = len(windows)
    before = (-1, -1)
    for i, j in [*pairs, (count, last)]:
        gap, between = i - before[0] - 1, j - before[1] - 1
        near = windows[min(max(before[1], 0), last - 1)] if last else 0
        for n in range(gap):
            if between:
                places[before[0] + 1 + n] = windows[before[1] + 1 + n * between // gap]
            elif gap < DROPPED:
                places[before[0] + 1 + n] = near
        if i < count:
            places[i] = windows[j]
        before = (i, j)
    return places


def _aligned(aligner: PieceAligner, samples: NDArray[np.float32], window: _Window) -> SpeechAlignment | None:
    """The words of a window, by pocketsphinx, else by speech of eSpeak NG; None where neither finds them."""
    piece = Sound(samples[window.begin : window.end], RATE)
    try:
        return aligner.align(piece, window.words)
    except FORGIVEN:
        pass
    if not can_speak():
        return None
    try:
        spoken = speak(" ".join(window.words), VOICE)
        path, _ = warp(piece, spoken)
    except PhonanimError:
        return None
    return SpeechAlignment(words_along(spoken, path), phones_along(spoken, path), piece.duration)


def _moved(intervals: Sequence[Interval], window: _Window) -> list[Interval]:
    """The intervals on the clock of the recording."""
    by = window.begin / RATE
    return [replace(one, start=one.start + by, end=one.end + by) for one in intervals]


def _notes(windows: Sequence[_Window], lost: Sequence[str]) -> list[str]:
    """What was left out, what was skipped, and what is doubtful."""
    notes = []
    if lost:
        notes.append(f"not heard, and left out: {_some(lost)}")
    if skipped := [_span(window) for window in windows if not window.words]:
        notes.append(f"without words of the text: {_some(skipped)}")
    doubtful = [
        f"{_span(window)} ({window.heard:.0%} of its words were heard)"
        for window in windows
        if window.words and window.heard < CLEAR
    ]
    if doubtful:
        notes.append(f"doubtful: {_some(doubtful)}")
    return notes


def _span(window: _Window) -> str:
    return f"{window.begin / RATE:.1f} to {window.end / RATE:.1f} s"


def _some(items: Sequence[str]) -> str:
    more = f" and {len(items) - MOST_SHOWN} more" if len(items) > MOST_SHOWN else ""
    return ", ".join(items[:MOST_SHOWN]) + more
