"""Align long recordings, and texts with errors: recognize words freely, match them with the text, align.

The recording is read in windows of at most 30 s that are cut where it is quiet. Whisper recognizes their
words and about when they are said. Matched with the text they give what each stretch of speech may say;
pocketsphinx finds which of it is said, and when.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

from phonanim.aligners._slots import Plan, Said, Stretch, plan_stretches, slot_of
from phonanim.aligners._windows import quiet_windows
from phonanim.aligners.espeak import VOICE, can_speak, speak
from phonanim.aligners.pocketsphinx import (
    FORGIVEN,
    FoundWord,
    PieceAligner,
    SpeechAlignment,
    split_words,
)
from phonanim.aligners.warping import phones_along, warp, words_along
from phonanim.aligners.whisper import RATE, RecognizedWord, recognize_words
from phonanim.core.threads import count_cores
from phonanim.errors import AlignmentError, PhonanimError
from phonanim.media.audio import Sound, audio_duration, resample
from phonanim.speech.alignment import Interval
from phonanim.speech.spoken_words import split_word
from phonanim.speech.written_forms import in_english_words

LEAST = 0.3  # share of a text that must be recognized
CLEAR = 0.6  # share of the words of a passage that were recognized, below which it is doubtful
PASSAGE = 5  # words of a passage
SILENT = 10.0  # seconds without words that are reported
MOST_SHOWN = 5


@dataclass(frozen=True, slots=True)
class Word:
    """A word in the recording, its phones, and how it was found: of the text, recognized, or both."""

    word: Interval
    phones: tuple[Interval, ...]
    owner: int | None
    recognized: bool
    probability: float


@dataclass
class Text:
    """A text: its words as written, in lower case, and what is said for each, with the place of its word."""

    labels: list[str]
    parts: list[str] = field(default_factory=list)
    owners: list[int] = field(default_factory=list)


def align_by_anchors(audio: Path, text: str, said: Sequence[Said] | None = None) -> SpeechAlignment:
    """Find the words and phones of an English text in a recording of any length; either may lack some.

    `said` are the words of the recording, if they were recognized before. Notes tell what was left out or
    added, and what is doubtful. Raises AlignmentError when less than a third of the text is recognized,
    MissingExtraError without the extras `recognize` and `align`.
    """
    written = _read_text(text)
    said = recognize_said(audio) if said is None else said
    plan = plan_stretches(written.parts, said)
    if plan.share < LEAST:
        raise AlignmentError(
            f"{audio}: only {plan.share:.0%} of the text is recognized in it; check that they match"
        )
    aligner = PieceAligner()
    words, missed = _find(audio, aligner, plan, written, said)
    if not words:
        raise AlignmentError(f"{audio}: the text cannot be found in the audio; check that they match")
    duration = audio_duration(audio)
    return SpeechAlignment(
        tuple(one.word for one in words),
        tuple(phone for one in words for phone in one.phones),
        duration,
        (*aligner.notes(dict.fromkeys(written.parts)), *_notes(plan, written, said, words, missed, duration)),
    )


def _read_text(text: str) -> Text:
    written = Text(split_words(in_english_words(text)))
    for number, label in enumerate(written.labels):
        for part in split_word(label):
            written.parts.append(part)
            written.owners.append(number)
    return written


def recognize_said(audio: Path) -> list[Said]:
    """The English words of a recording; windows are recognized in as many threads as there are cores.

    Raises AudioError, MissingExtraError.
    """
    said: list[Said] = []
    for number, (begin, words) in enumerate(_recognized_windows(audio)):
        for word in words:
            for label in split_words(word.text):
                for part in split_word(label):
                    said.append(Said(part, number, begin + word.start, begin + word.end, word.probability))
    return said


def _recognized_windows(audio: Path) -> Iterator[tuple[float, list[RecognizedWord]]]:
    """The begin in seconds of each window, and its words. Few windows are in memory at once."""
    cores = count_cores()
    waiting: deque[tuple[float, Future[list[RecognizedWord]]]] = deque()
    with ThreadPoolExecutor(cores) as threads:
        for begin, sound in quiet_windows(audio):
            waiting.append((begin, threads.submit(_recognize_in, sound)))
            while len(waiting) > cores:
                first, words = waiting.popleft()
                yield first, words.result()
        for first, words in waiting:
            yield first, words.result()


def _recognize_in(sound: Sound) -> list[RecognizedWord]:
    return recognize_words(resample(sound.samples, sound.rate, RATE))


def _find(
    audio: Path, aligner: PieceAligner, plan: Plan, text: Text, said: Sequence[Said]
) -> tuple[list[Word], list[Stretch]]:
    """The words of all stretches in order, and the stretches that were not found."""
    slots = {id(one): [slot_of(choice, text.parts, said) for choice in one.choices] for one in plan.stretches}
    aligner.learn(word for stretch in slots.values() for slot in stretch for run in slot for word in run)
    words: list[Word] = []
    missed: list[Stretch] = []
    waiting = deque(plan.stretches)
    for number, (begin, sound) in enumerate(quiet_windows(audio)):
        while waiting and waiting[0].window == number:
            stretch = waiting.popleft()
            first = max(round((stretch.start - begin) * sound.rate), 0)
            piece = Sound(sound.samples[first : round((stretch.end - begin) * sound.rate)], sound.rate)
            by = begin + first / sound.rate
            try:
                runs = aligner.find(piece, slots[id(stretch)])
            except FORGIVEN:
                found = _warped(piece, stretch, text, by)
            else:
                found = list(_told(stretch, runs, text, said, by))
            words += found
            missed += [stretch] * (not found)
    return words, missed


def _told(
    stretch: Stretch,
    runs: Iterable[tuple[tuple[str, ...], list[FoundWord]]],
    text: Text,
    said: Sequence[Said],
    by: float,
) -> Iterator[Word]:
    """The words of a stretch; those that say one word of the text, such as a number, are joined."""
    last: Word | None = None
    for choice, (run, found) in zip(stretch.choices, runs, strict=True):
        of_text = run == tuple(text.parts[i] for i in choice.text)
        sure = min((said[j].probability for j in choice.recognized), default=0.0)
        for number, one in enumerate(found):
            owner = text.owners[choice.text[number]] if of_text else None
            label = one.word.label if owner is None else text.labels[owner]
            word = Word(
                replace(_later(one.word, by), label=label),
                tuple(_later(phone, by) for phone in one.phones),
                owner,
                choice.sure or not of_text,
                sure if choice.sure or not of_text else 0.0,
            )
            if last is not None and owner is not None and last.owner == owner:
                last = _joined(last, word)
                continue
            if last is not None:
                yield last
            last = word
    if last is not None:
        yield last


def _joined(one: Word, two: Word) -> Word:
    return replace(
        one,
        word=replace(one.word, end=two.word.end),
        phones=one.phones + two.phones,
        recognized=one.recognized and two.recognized,
        probability=min(one.probability, two.probability),
    )


def _warped(piece: Sound, stretch: Stretch, text: Text, by: float) -> list[Word]:
    """The text's words of a stretch by speech of eSpeak NG; none where that does not find them either."""
    if not can_speak():
        return []
    owners = dict.fromkeys(text.owners[i] for choice in stretch.choices for i in choice.text)
    try:
        spoken = speak(" ".join(text.labels[owner] for owner in owners), VOICE)
        path, _ = warp(piece, spoken)
    except PhonanimError:
        return []
    phones = [_later(phone, by) for phone in phones_along(spoken, path)]
    words = [_later(word, by) for word in words_along(spoken, path)]
    ends = [*(word.start for word in words[1:]), float("inf")]
    return [
        Word(word, tuple(p for p in phones if word.start - 1e-6 <= p.start < end - 1e-6), None, False, 0.0)
        for word, end in zip(words, ends, strict=True)
    ]


def _later(interval: Interval, by: float) -> Interval:
    return replace(interval, start=interval.start + by, end=interval.end + by)


def _notes(
    plan: Plan, text: Text, said: Sequence[Said], words: Sequence[Word], missed: Sequence[Stretch], end: float
) -> Iterator[str]:
    """What was left out, added or skipped, and what is doubtful."""
    there = {word.owner for word in words}
    lost = [label for owner, label in enumerate(text.labels) if owner not in there]
    if lost:
        yield f"of the text, not said, and left out: {_some(lost)}"
    added = [f"{word.word.label} ({word.word.start:.1f} s)" for word in words if word.owner is None]
    if added:
        yield f"said, but not in the text, and added: {_some(added)}"
    if asides := [_aside(run, said) for run in plan.asides]:
        yield f"said, but not in the text, and left out: {_some(asides)}"
    bounds = [(0.0, 0.0), *((one.word.start, one.word.end) for one in words), (end, end)]
    gaps = [(a, b) for (_, a), (b, _) in pairwise(bounds) if b - a > SILENT]
    if gaps:
        yield f"without words of the text: {_some([f'{a:.1f} to {b:.1f} s' for a, b in gaps])}"
    doubtful = [
        f"{a:.1f} to {b:.1f} s ({share:.0%} of its words were recognized)" for a, b, share in _doubts(words)
    ]
    if doubtful:
        yield f"doubtful: {_some(doubtful)}"


def _aside(run: Sequence[int], said: Sequence[Said]) -> str:
    first = " ".join(said[j].word for j in run[:MOST_SHOWN])
    return f"{said[run[0]].start:.1f} to {said[run[-1]].end:.1f} s ({first} ...)"


def _doubts(words: Sequence[Word]) -> Iterator[tuple[float, float, float]]:
    """Begin, end and share of words recognized of passages that are doubtful."""
    doubtful = [False] * len(words)
    for first in range(max(len(words) - PASSAGE, 0) + 1):
        part = words[first : first + PASSAGE]
        if sum(word.recognized for word in part) < CLEAR * len(part):
            doubtful[first : first + len(part)] = [True] * len(part)
    begin = 0
    while begin < len(words):
        after = begin
        while after < len(words) and doubtful[after]:
            after += 1
        if after > begin:
            part = words[begin:after]
            share = sum(word.recognized for word in part) / len(part)
            yield part[0].word.start, part[-1].word.end, share
        begin = after + 1


def _some(items: Sequence[str]) -> str:
    more = f" and {len(items) - MOST_SHOWN} more" if len(items) > MOST_SHOWN else ""
    return ", ".join(items[:MOST_SHOWN]) + more
