"""Align a recording with its text by the aligner that suits its language and its length."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from phonanim.aligners.espeak import VOICE, can_speak, reading_language
from phonanim.aligners.pocketsphinx import SpeechAlignment, align
from phonanim.aligners.warping import align_by_speech
from phonanim.aligners.whisper import can_recognize
from phonanim.errors import AlignmentError
from phonanim.media.audio import audio_duration
from phonanim.speech.spoken_text import plain_text

ENGLISH = "english"
AT_ONCE = 30.0  # seconds of English that pocketsphinx aligns at once
WARPED = 60.0  # seconds that are warped at once


def align_recording(audio: Path, text: str, voice: str | None) -> tuple[SpeechAlignment, str]:
    """Find the words and phones of a text in a recording: the alignment, and the language of its labels.

    English (`voice` None) is aligned by pocketsphinx; where that does not find the text, by the words that
    are recognized (extra `recognize`), or by speech that eSpeak NG makes. Other languages are aligned by made
    speech. Recordings that are long are aligned in parts. Marks, directions and names of speakers in the text
    are not looked for, with a note. Raises AlignmentError, AudioError, OptionError and MissingExtraError, as
    the aligners do.
    """
    plain, notes = plain_text(text, voice or VOICE)
    found, language = _align_plain(audio, plain, voice)
    return replace(found, notes=(*notes, *found.notes)), language


def _align_plain(audio: Path, text: str, voice: str | None) -> tuple[SpeechAlignment, str]:
    duration = audio_duration(audio)
    if voice is not None:
        by_speech = (
            align_by_speech(audio, text, voice) if duration <= WARPED else align_long(audio, text, voice)
        )
        return by_speech, reading_language(voice)
    if duration > AT_ONCE:
        return align_long(audio, text, None), ENGLISH
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


def align_long(audio: Path, text: str, voice: str | None) -> SpeechAlignment:
    """Find the words and phones of a text in a recording of any length, also where some words are wrong.

    English (`voice` None) goes by the words that Whisper recognizes with the extra `recognize`, else, as
    any other language, by speech that eSpeak NG makes. Raises AlignmentError, AudioError, MissingExtraError.
    """
    if voice is None and can_recognize():
        from phonanim.aligners.anchors import align_by_anchors

        return align_by_anchors(audio, text)
    if not can_speak():
        raise AlignmentError(
            f"{audio}: long recordings are aligned by the words recognized in them (pip install "
            "'phonanim[recognize]'), or by speech made from the text (pip install 'phonanim[espeak]')"
        )
    from phonanim.aligners.coarse import align_in_parts

    return align_in_parts(audio, text, voice or VOICE)
