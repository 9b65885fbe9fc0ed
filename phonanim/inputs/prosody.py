"""What the sound of a line gives: voice, prosody and loudness, from phones, a recording, or both."""

from __future__ import annotations

from dataclasses import replace

from phonanim.errors import AudioError, MissingExtraError
from phonanim.inputs.speech_input import SpeechInput, sound_from
from phonanim.media.audio import read_sound
from phonanim.media.praat import with_praat_pitch
from phonanim.media.voice import Voice, analyze_voice
from phonanim.options import Options
from phonanim.speech.loudness import measure_loudness
from phonanim.speech.prosody import AHEAD, Prosody, measure_prosody, read_prosody

SPARE = 0.02  # seconds of a model's look-ahead that are lost to rounding


def add_prosody(
    source: SpeechInput, regressor: object, options: Options, loudness: bool, prosody: bool
) -> SpeechInput:
    """The same input with its voice, and with the loudness and the prosody where they are asked for.

    An unreadable recording counts as none. Without Praat, the pitch is our own, and a note says so.
    """
    voice, notes = _find_voice(source, options.pitch) if loudness or prosody else (None, ())
    level = options.level
    return replace(
        source,
        notes=(*source.notes, *notes),
        voice=voice,
        loudness=measure_loudness(voice, source.track, level) if voice is not None and loudness else None,
        prosody=_find_prosody(source, regressor, voice) if prosody else None,
    )


def life_ahead(regressor: object) -> float:
    """Seconds of audio after a frame that may decide its life: the look-ahead of a streamed model."""
    return max(min(getattr(regressor, "look_ahead", AHEAD), AHEAD) - SPARE, 0.0)


def _find_prosody(source: SpeechInput, regressor: object, voice: Voice | None) -> Prosody:
    """The prosody of a line; without phones, no frame uses more look-ahead than the model."""
    if voice is not None and not source.alignment.intervals:
        return measure_prosody(voice, life_ahead(regressor))
    return read_prosody(source.track, source.alignment.words, voice=voice)


def _find_voice(source: SpeechInput, method: str) -> tuple[Voice | None, tuple[str, ...]]:
    """Level and pitch of the recording, None without a readable recording; and a note on the pitch."""
    sound = source.sound
    if sound is None and source.audio is not None:
        try:
            sound = sound_from(read_sound(source.audio), source.alignment)
        except (AudioError, MissingExtraError):
            return None, ()
    if sound is None:
        return None, ()
    voice = analyze_voice(sound.samples, sound.rate)
    if method == "praat":
        try:
            return with_praat_pitch(voice, sound.samples, sound.rate), ()
        except MissingExtraError as error:
            return voice, (f"{error}; the built-in estimate is used",)
    return voice, ()
