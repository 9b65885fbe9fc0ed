"""Alignments that `phonanim animate --text` makes: of a recording, or of speech that eSpeak NG speaks."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from phonanim.errors import OptionError
from phonanim.speech.doubts import doubts
from phonanim.speech.textgrid import write_textgrid

if TYPE_CHECKING:
    from collections.abc import Sequence

    from phonanim.aligners._slots import Said
    from phonanim.aligners.espeak import SpokenText
    from phonanim.aligners.pocketsphinx import SpeechAlignment
    from phonanim.aligners.whisper import Transcript
    from phonanim.commands import Console
    from phonanim.options import Options

CLEAR = 0.5  # confidence below which recognized words are refused


def align_recording(
    recording: Path, text: str | None, voice: str | None, console: Console
) -> tuple[Path, str]:
    """Align a recording with its text, into a TextGrid beside it: its path, and the language of its labels.

    In the language of `voice`, or in English when it is None. Without text the words are recognized. What was
    understood, and notes, are printed. Raises OptionError if the TextGrid exists.
    """
    path = recording.with_suffix(".TextGrid")
    if path.exists():
        raise OptionError(f"{path}: already exists; animate it, or remove it to make it again")
    from phonanim.aligners.long import align_recording as align_by_text

    words, said = understand(recording, voice, console) if text is None else (text, None)
    found, language = align_by_text(recording, words, voice, said)
    print_notes(found, console)
    write_textgrid(path, found.tiers, found.duration)
    return path, language


def align_subtitles(path: Path, audio: Path, options: Options, console: Console) -> tuple[Path, Options]:
    """Align lines of text that have times with their recording, into a TextGrid beside them.

    Its path and how to read it; those that are given, where there is nothing to align. Raises OptionError if
    another TextGrid of that name exists.
    """
    from phonanim.aligners.cues import align_cues

    aligned = align_cues(path, audio, options)
    if aligned is None:
        return path, options
    found, language = aligned
    target = path.with_suffix(".aligned.TextGrid")
    with tempfile.TemporaryDirectory(prefix="phonanim-") as folder:
        fresh = Path(folder) / target.name
        write_textgrid(fresh, found.tiers, found.duration)
        if target.exists() and target.read_bytes() != fresh.read_bytes():
            raise OptionError(f"{target}: is there already, with other times; animate it, or remove it")
    write_textgrid(target, found.tiers, found.duration)
    print_notes(found, console)
    return target, replace(options, language=language)


def print_notes(found: SpeechAlignment, console: Console) -> None:
    """Print the notes of an alignment but its doubts, which are in its file and told when that is read."""
    told_later = doubts(found.words, found.confidence)
    for note in found.notes:
        if note not in told_later:
            console.print(f"note: {note}")


def why_no_words(voice: str | None) -> str:
    """Why the words of a recording cannot be recognized, and how to have better ones; "" where they can."""
    from importlib.util import find_spec

    from phonanim.aligners.whisper import can_recognize

    if voice is not None and not voice.startswith("en"):
        return "words are recognized in English alone, and giving them with --text is better"
    extras = {"recognize": can_recognize(), "align": find_spec("pocketsphinx") is not None}
    absent = ",".join(extra for extra, there in extras.items() if not there)
    return f"recognizing words, which is better, needs pip install 'phonanim[{absent}]'" if absent else ""


def understand(recording: Path, voice: str | None, console: Console) -> tuple[str, Sequence[Said] | None]:
    """The words of an English recording, by Whisper; they are printed. Of a long one, with their times.

    Raises OptionError for another language and where the words are not clear, and MissingExtraError without
    the extra `recognize`.
    """
    if voice is not None and not voice.startswith("en"):
        raise OptionError(
            f"{recording}: words are recognized in English only; give them with --text, or choose --model "
            "audio, which recognizes phones of any language"
        )
    words, said = _recognized(recording)
    if words.confidence < CLEAR:
        raise OptionError(
            f"{recording}: its words are not clear ({words.confidence:.0%} sure: {words.text!r}); give them "
            "with --text, and with --voice the language of speech that is not English, or choose --model "
            "audio, which recognizes phones"
        )
    console.print(f"understood ({words.confidence:.0%} sure): {words.text}")
    return words.text, said


def _recognized(recording: Path) -> tuple[Transcript, Sequence[Said] | None]:
    """The transcript of a recording; long ones are recognized in windows, whose words are aligned later."""
    from phonanim.aligners.long import AT_ONCE
    from phonanim.aligners.whisper import recognize, transcript_of
    from phonanim.media.audio import audio_duration, read_sound

    if audio_duration(recording) <= AT_ONCE:
        return recognize(read_sound(recording), str(recording)), None
    from phonanim.aligners.anchors import recognize_said

    said = recognize_said(recording)
    return transcript_of([(one.word, one.probability) for one in said], str(recording)), said


def speak_text(text: str, voice: str, beside: Path, console: Console) -> Path:
    """Speak a text into `beside` with the suffixes .wav and .TextGrid, and return the TextGrid.

    The phones are in IPA. Notes on the text are printed. Files that speak this text already are left as they
    are. Raises OptionError when one of the two exists with other content.
    """
    from phonanim.aligners.espeak import speak

    spoken = speak(text, voice)
    for note in spoken.notes:
        console.print(f"note: {note}")
    sound, grid = beside.with_suffix(".wav"), beside.with_suffix(".TextGrid")
    with tempfile.TemporaryDirectory(prefix="phonanim-") as folder:
        for path in (sound, grid):
            fresh = Path(folder) / path.name
            _write(fresh, spoken)
            if path.exists() and path.read_bytes() != fresh.read_bytes():
                raise OptionError(
                    f"{path}: already exists, with other speech; choose another -o, or remove it"
                )
    _write(sound, spoken)
    _write(grid, spoken)
    return grid


def _write(path: Path, spoken: SpokenText) -> None:
    """The sound or the TextGrid, by the suffix."""
    from phonanim.aligners.espeak import write_speech

    if path.suffix == ".wav":
        write_speech(path, spoken)
    else:
        write_textgrid(path, {"words": spoken.words, "phones": spoken.phones}, spoken.duration)
