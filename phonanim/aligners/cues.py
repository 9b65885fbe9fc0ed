"""Align lines of text that have times, such as subtitles, with their recording: each line within its time."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from phonanim.aligners.confidence import with_confidence
from phonanim.aligners.espeak import VOICE, SpokenText, can_speak, reading_language, speak
from phonanim.aligners.long import ENGLISH
from phonanim.aligners.pocketsphinx import FORGIVEN, PieceAligner, SpeechAlignment, split_words
from phonanim.aligners.warping import phones_along, warp, words_along
from phonanim.errors import AudioError, LabelError, MissingExtraError, PhonanimError
from phonanim.media.audio import Sound, read_sound
from phonanim.options import Options
from phonanim.readers import read_recording
from phonanim.readers._words import SPREAD
from phonanim.speech.alignment import Interval, Recording
from phonanim.speech.alignment_file import open_alignment_file
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import is_auto, one_expected
from phonanim.speech.spoken_words import is_sound

AROUND = 0.3  # seconds before and after a line in which its words may lie, where no other line does
TOUCHING = 1e-6
LONGEST = 25.0  # seconds that are aligned together


def align_cues(path: Path, audio: Path, options: Options) -> tuple[SpeechAlignment, str] | None:
    """The words and phones of lines of text, aligned within each line; and the language of the phones.

    None where that is not to be done: the file times its words, names several speakers, a unit or an offset
    is given, the recording cannot be read, or the extras that align (`align`, `espeak`) are not there.
    Raises AlignmentError when the file cannot be read.
    """
    source = open_alignment_file(path)
    recording = read_recording(source)
    words = _spread_words(recording, options)
    voice = _voice(recording, options)
    if not words or not _can_align(voice):
        return None
    try:
        sound = read_sound(audio)
    except (AudioError, MissingExtraError):
        return None
    language = ENGLISH if voice is None else reading_language(voice)
    return with_confidence(_aligned(words, sound, voice), audio, language), language


def _spread_words(recording: Recording, options: Options) -> tuple[Interval, ...]:
    """The words of a file that gives times to lines alone; () for other files."""
    tiers = [
        tier for tier in recording.tiers if tier.name == "words" and options.speaker in (None, tier.speaker)
    ]
    fits = SPREAD in recording.notes and len(tiers) == 1 and len(recording.tiers) >= 1
    return tiers[0].intervals if fits and options.unit is None and options.offset is None else ()


def _voice(recording: Recording, options: Options) -> str | None:
    """The voice of the language that the options or the file name; None for English."""
    language = one_expected(options.language) if is_auto(options.language) else options.language
    try:
        code = load_language(language).code if language else recording.spoken.lower()
    except LabelError:
        return None
    return None if not code or code.startswith("en") else code


def _can_align(voice: str | None) -> bool:
    return can_speak() or (voice is None and importlib.util.find_spec("pocketsphinx") is not None)


def _aligned(words: Sequence[Interval], sound: Sound, voice: str | None) -> SpeechAlignment:
    lines = _lines([word for word in words if not is_sound(word.label)])
    aligner = PieceAligner()
    found: list[SpeechAlignment] = []
    lost = 0
    for number, line in enumerate(lines):
        before = lines[number - 1][-1].end if number else 0.0
        after = lines[number + 1][0].start if number + 1 < len(lines) else sound.duration
        begin = max(line[0].start - AROUND, min(before, line[0].start), 0.0)
        end = min(line[-1].end + AROUND, max(after, line[-1].end), sound.duration)
        piece = Sound(sound.samples[round(begin * sound.rate) : round(end * sound.rate)], sound.rate)
        inner = _line(aligner, piece, [word.label for word in line], voice)
        lost += inner is None
        found.append(_later(inner, begin) if inner else _even(line, voice))
    notes = [f"the words of {len(lines)} lines are aligned within the time of each"]
    if lost:
        notes.append(
            f"{lost} of these lines do not fit their sound, and their words share the time of the line"
        )
    return SpeechAlignment(
        tuple(word for one in found for word in one.words),
        tuple(phone for one in found for phone in one.phones),
        sound.duration,
        (*aligner.notes(dict.fromkeys(split_words(" ".join(word.label for word in words)))), *notes),
    )


def _lines(words: Sequence[Interval]) -> list[list[Interval]]:
    """Words that follow each other without a gap, as those of a line do."""
    lines: list[list[Interval]] = []
    for word in words:
        last = lines[-1] if lines else []
        if last and word.start - last[-1].end < TOUCHING and word.end - last[0].start < LONGEST:
            last.append(word)
        else:
            lines.append([word])
    return lines


def _line(aligner: PieceAligner, piece: Sound, words: list[str], voice: str | None) -> SpeechAlignment | None:
    """The words of a line in its sound; None where they are not found."""
    if voice is None:
        try:
            return aligner.align(piece, split_words(" ".join(words)))
        except (MissingExtraError, *FORGIVEN):
            pass
    try:
        spoken = speak(" ".join(words), voice or VOICE)
        path, _ = warp(piece, spoken)
    except PhonanimError:
        return None
    return SpeechAlignment(words_along(spoken, path), phones_along(spoken, path), piece.duration)


def _even(line: Sequence[Interval], voice: str | None) -> SpeechAlignment:
    """The words of a line in its time, each phone as long as eSpeak NG makes it; words alone without it."""
    begin, end = line[0].start, line[-1].end
    try:
        spoken = speak(" ".join(word.label for word in line), voice or VOICE)
    except PhonanimError:
        return SpeechAlignment(tuple(line), (), end)
    return SpeechAlignment(
        _stretched(spoken.words, spoken, begin, end), _stretched(spoken.phones, spoken, begin, end), end
    )


def _stretched(
    intervals: Sequence[Interval], spoken: SpokenText, begin: float, end: float
) -> tuple[Interval, ...]:
    first, last = spoken.phones[0].start, spoken.phones[-1].end
    scale = (end - begin) / (last - first)
    return tuple(
        replace(one, start=begin + (one.start - first) * scale, end=begin + (one.end - first) * scale)
        for one in intervals
    )


def _later(found: SpeechAlignment, by: float) -> SpeechAlignment:
    def moved(intervals: Sequence[Interval]) -> tuple[Interval, ...]:
        return tuple(replace(one, start=one.start + by, end=one.end + by) for one in intervals)

    return replace(found, words=moved(found.words), phones=moved(found.phones))
