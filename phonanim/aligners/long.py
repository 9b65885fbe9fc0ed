"""Align a recording with its text by the aligner that suits its language and its length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from phonanim.aligners._slots import Said
from phonanim.aligners.confidence import with_confidence
from phonanim.aligners.espeak import VOICE, can_speak, reading_language
from phonanim.aligners.pocketsphinx import SpeechAlignment, align
from phonanim.aligners.warping import align_by_speech
from phonanim.aligners.whisper import can_recognize
from phonanim.errors import AlignmentError
from phonanim.media.audio import audio_duration
from phonanim.speech.doubts import doubtful_time
from phonanim.speech.spoken_text import plain_text

ENGLISH = "english"
AT_ONCE = 30.0  # seconds of English that pocketsphinx aligns at once
WARPED = 60.0  # seconds that are warped at once
MENDED = 0.8  # doubtful seconds of short English from which it is aligned by recognized words as well
BETTER = 0.5  # share of the doubtful seconds that may remain if that is taken


def align_recording(
    audio: Path, text: str, voice: str | None, said: Sequence[Said] | None = None
) -> tuple[SpeechAlignment, str]:
    """Find the words and phones of a text in a recording: the alignment, and the language of its labels.

    English (`voice` None) is aligned by pocketsphinx; where that does not find the text, by the words that
    are recognized (extra `recognize`), or by speech that eSpeak NG makes. Other languages are aligned by made
    speech. Recordings that are long are aligned in parts. Marks, directions and names of speakers in the text
    are not looked for, with a note. `said` are words that were recognized in English before. Each word has a
    confidence, and a note tells what is doubtful. Raises AlignmentError, AudioError, OptionError and
    MissingExtraError, as the aligners do.
    """
    plain, notes = plain_text(text, voice or VOICE)
    found, language = _align_plain(audio, plain, voice, said)
    found = with_confidence(found, audio, language)
    if voice is None and audio_duration(audio) <= AT_ONCE and doubtful_time(found.confidence) > MENDED:
        found = _surer(found, audio, plain)
    return replace(found, notes=(*notes, *found.notes)), language


def _surer(found: SpeechAlignment, audio: Path, text: str) -> SpeechAlignment:
    """The alignment of an English text, or that by recognized words where less of it is doubtful."""
    if not can_recognize():
        return found
    try:
        other = with_confidence(align_long(audio, text, None), audio, ENGLISH)
    except AlignmentError:
        return found
    if doubtful_time(other.confidence) > BETTER * doubtful_time(found.confidence):
        return found
    note = "parts of the text do not fit the audio; aligned by the words recognized in it instead"
    return replace(other, notes=(note, *other.notes))


def _align_plain(
    audio: Path, text: str, voice: str | None, said: Sequence[Said] | None
) -> tuple[SpeechAlignment, str]:
    duration = audio_duration(audio)
    if voice is not None:
        by_speech = (
            align_by_speech(audio, text, voice) if duration <= WARPED else align_long(audio, text, voice)
        )
        return by_speech, reading_language(voice)
    if duration > AT_ONCE:
        return align_long(audio, text, None, said), ENGLISH
    try:
        return align(audio, text), ENGLISH
    except AlignmentError as error:
        if not (can_recognize() or can_speak()):
            raise
        found, how = _align_otherwise(audio, text)
        return replace(found, notes=(f"{error}; aligned {how} instead", *found.notes)), ENGLISH


def _align_otherwise(audio: Path, text: str) -> tuple[SpeechAlignment, str]:
    """The alignment of a short English recording without pocketsphinx alone, and how it was made."""
    if can_recognize():
        try:
            return align_long(audio, text, None), "by the words recognized in it"
        except AlignmentError:
            if not can_speak():
                raise
    return align_by_speech(audio, text, VOICE), "with speech of eSpeak NG"


def align_long(
    audio: Path, text: str, voice: str | None, said: Sequence[Said] | None = None
) -> SpeechAlignment:
    """Find the words and phones of a text in a recording of any length, also where some words are wrong.

    English (`voice` None) goes by the words that Whisper recognizes with the extra `recognize`, else, as
    any other language, by speech that eSpeak NG makes. Raises AlignmentError, AudioError, MissingExtraError.
    """
    if voice is None and can_recognize():
        from phonanim.aligners.anchors import align_by_anchors

        return align_by_anchors(audio, text, said)
    if not can_speak():
        raise AlignmentError(
            f"{audio}: long recordings are aligned by the words recognized in them (pip install "
            "'phonanim[recognize]'), or by speech made from the text (pip install 'phonanim[espeak]')"
        )
    from phonanim.aligners.coarse import align_in_parts

    return align_in_parts(audio, text, voice or VOICE)
