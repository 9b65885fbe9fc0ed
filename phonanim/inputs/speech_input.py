"""The input of a line: an alignment, a recording, or both, as the model requires."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from phonanim.errors import AlignmentError, AudioError
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import RECORDINGS, Sound, audio_notes, find_audio, read_sound, truncation_note
from phonanim.media.voice import Voice
from phonanim.options import Options
from phonanim.recognition.recognizer import LANGUAGE, recognize_phones
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.language import ReadingLanguage, read_phones
from phonanim.speech.loudness import Loudness
from phonanim.speech.phone_changes import PhoneChanges, correct_phones
from phonanim.speech.phones import PhoneTrack, silent_track
from phonanim.speech.prosody import Prosody

InputModality = Literal["phones", "audio", "both", "recognized"]
"""What a model reads: phones, audio, both, or phones that are recognized where there is no alignment."""

UNENFORCED = "there is no alignment: lip closures are as predicted from the audio, none is enforced"
UNCHANGED = PhoneChanges()
RECOGNIZED = "the phones were recognized, not given, so some are wrong: an alignment or --text is surer"
APART = 0.5  # seconds between the ends of a recording and its alignment above which a note is given


@dataclass(frozen=True, slots=True)
class SpeechInput:
    """All that a line is animated from.

    The alignment and its phones (all silence without an alignment), the path of the recording, and its sound
    if the model uses it. `voice`, `loudness` and `prosody` are what its sound gives, None where not needed.
    `language` is the language that the labels were read as, None without an alignment; `read` are the phones
    before they were corrected.
    """

    alignment: Alignment
    track: PhoneTrack
    notes: tuple[str, ...]
    sound: Sound | None
    audio: Path | None
    voice: Voice | None = None
    loudness: Loudness | None = None
    prosody: Prosody | None = None
    language: ReadingLanguage | None = None
    read: tuple[Interval, ...] = ()


def read_speech_input(
    path: Path,
    options: Options,
    audio: Path | None,
    modality: InputModality,
    changes: PhoneChanges = UNCHANGED,
    recognizer: Path | None = None,
) -> SpeechInput:
    """Read an alignment or a recording, and for an audio-driven model the recording next to an alignment.

    `changes` are phones that a person corrected. `recognizer` is the network that recognizes phones.

    Raises AlignmentError when a recording is given to a phone-driven model, AudioError when an audio-driven
    model has no recording or no speech is recognized in it, and the errors of reading either.
    """
    if is_recording(path):
        if recognizer is not None:
            return _recognize_recording(path, recognizer, changes)
        return _read_recording(path, modality, options.features)
    read = read_with_options(path, options, audio)
    alignment, left = correct_phones(read, changes)
    reading = read_phones(alignment, options.language, options.unknown, options.fallback)
    track, notes = reading.track, (*left, *reading.notes)
    sound = None
    if modality in ("audio", "both"):
        audio = audio or find_audio(path)
        if audio is None:
            raise AudioError(f"{path}: has no recording next to it for this audio-driven model; give --audio")
        sound = sound_from(_read_sound(audio, options.features), alignment)
        notes = (*notes, *audio_notes(sound), *truncation_note(audio))
        if modality == "both":
            notes = (*notes, *_apart(audio, sound.duration, track.duration))
    return SpeechInput(alignment, track, notes, sound, audio, language=reading.language, read=read.intervals)


def is_recording(path: Path) -> bool:
    """Whether a path names a recording, by its suffix."""
    return path.suffix.lower() in RECORDINGS


def _read_sound(path: Path, features: str | None) -> Sound:
    sound = read_sound(path)
    return replace(sound, features=Path(features)) if features else sound


def _read_recording(path: Path, modality: InputModality, features: str | None) -> SpeechInput:
    if modality != "audio":
        raise AlignmentError(
            f"{path}: is a recording, and this model needs an alignment; give the spoken words with --text, "
            "or choose --model audio, which recognizes phones"
        )
    sound = _read_sound(path, features)
    nothing = Alignment((), sound.duration, "", str(path))
    notes = (UNENFORCED, *audio_notes(sound), *truncation_note(path))
    return SpeechInput(nothing, silent_track(sound.duration), notes, sound, path)


def _recognize_recording(path: Path, recognizer: Path, changes: PhoneChanges) -> SpeechInput:
    """A recording with the phones that a network recognizes in it, and corrections of them."""
    sound = read_sound(path)
    read = recognize_phones(sound, recognizer, str(path))
    corrected, left = correct_phones(read, changes)
    track = read_phones(corrected, LANGUAGE).track
    notes = (RECOGNIZED, *left, *audio_notes(sound), *truncation_note(path))
    return SpeechInput(corrected, track, notes, None, path, read=read.intervals)


def _apart(audio: Path, recorded: float, aligned: float) -> tuple[str, ...]:
    """A note when a recording and its alignment, of these durations in seconds, do not end together."""
    if abs(recorded - aligned) <= APART:
        return ()
    shorter = "the recording" if recorded < aligned else "the alignment"
    lasts = f"{audio} lasts {recorded:.2f} s and the alignment {aligned:.2f} s"
    return (f"{lasts}; after its end, {shorter} counts as silent",)


def read_with_options(path: Path, options: Options, audio: Path | None = None) -> Alignment:
    """An alignment, read as the options say; the length of the recording decides where times are in doubt."""
    return read_alignment(
        path,
        options.tier,
        options.speaker,
        options.lexicon,
        options.unknown,
        options.language,
        options.unit,
        options.offset,
        audio or find_audio(path),
    )


def sound_from(sound: Sound, alignment: Alignment) -> Sound:
    """The sound of an alignment: of a part of a longer recording, that part of it.

    A recording that ends before the part does was cut out itself, and is used whole.
    """
    offset = alignment.offset
    if offset <= 0 or sound.duration < offset + alignment.duration / 2:
        return sound
    return Sound(sound.samples[round(offset * sound.rate) :], sound.rate)
