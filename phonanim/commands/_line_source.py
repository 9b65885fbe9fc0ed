"""Find what `phonanim animate` reads: an alignment, a recording, or one that is made of text first."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from phonanim.commands import Console

if TYPE_CHECKING:
    from phonanim.options import Options


def find_source(
    alignment: Path | None,
    text: str | None,
    voice: str | None,
    beside: Path,
    audio: Path | None,
    options: Options,
    console: Console,
) -> tuple[Path, Options, Path | None]:
    """What to animate, which may have to be made first; how to read it; and the recording."""
    words = text is not None
    if alignment is not None and not words and needs_words(alignment, options):
        options = with_phones_recognized(alignment, voice, options, console)
        words = needs_words(alignment, options)
    if alignment is None or words:
        made, options, recording = make_alignment(alignment, text, voice, beside, options, console)
        return made, options, audio or recording
    return with_lines_aligned(alignment, audio, options, console)


def with_lines_aligned(
    alignment: Path, audio: Path | None, options: Options, console: Console
) -> tuple[Path, Options, Path | None]:
    """The alignment, how to read it, and the recording; of lines of text, one made of both."""
    from phonanim.media.audio import find_audio
    from phonanim.readers import LINES

    recording = audio or find_audio(alignment)
    if recording is None or alignment.suffix.lower() not in LINES:
        return alignment, options, audio
    from phonanim.commands._speech import align_subtitles

    path, settings = align_subtitles(alignment, recording, options, console)
    return path, settings, audio if path == alignment else recording


def needs_words(path: Path, options: Options) -> bool:
    """Whether a path is a recording whose words have to be found, because the model needs phones."""
    from phonanim.inputs.speech_input import is_recording
    from phonanim.pipeline import load_model

    return is_recording(path) and load_model(options.model).input_modality not in ("audio", "recognized")


def with_phones_recognized(recording: Path, voice: str | None, options: Options, console: Console) -> Options:
    """The options with the model that recognizes phones, where words cannot be recognized; a line says why.

    Only where no model was chosen: words need the extras `recognize` and `align`, and are English alone.
    """
    from phonanim.commands._speech import why_no_words
    from phonanim.core.catalog import RECOGNITION_MODEL

    if click.get_current_context().get_parameter_source("model") is not ParameterSource.DEFAULT:
        return options
    why = why_no_words(voice_of(voice, options))
    if not why:
        return options
    console.print(f"{recording}: {why}; so --model {RECOGNITION_MODEL} recognizes phones, many of them wrong")
    return replace(options, model=RECOGNITION_MODEL)


def make_alignment(
    recording: Path | None,
    text: str | None,
    voice: str | None,
    beside: Path,
    options: Options,
    console: Console,
) -> tuple[Path, Options, Path | None]:
    """The alignment of a recording, or of speech that is made from text; how to read it; and the recording.

    The words of a recording are its text, or recognized. Speech in another language than English is aligned,
    and text alone is spoken, with the voice, or with the voice of the language. Made speech and its alignment
    are written beside the first output. Raises click.UsageError when there is neither a recording nor text.
    """
    from phonanim.aligners.espeak import VOICE, reading_language
    from phonanim.commands._speech import align_recording, speak_text

    named = voice_of(voice, options)
    if recording is not None:
        path, language = align_recording(recording, text, named, console)
        return path, replace(options, language=language), recording
    if text is None:
        raise click.UsageError("give an ALIGNMENT, a recording, or --text")
    voice = named or VOICE
    return speak_text(text, voice, beside, console), replace(options, language=reading_language(voice)), None


def voice_of(voice: str | None, options: Options) -> str | None:
    """The voice that is named, or that of the language; None for English."""
    from phonanim.speech.language_files import load_language
    from phonanim.speech.language_names import is_auto

    code = None if is_auto(options.language) else load_language(options.language).code
    return voice or (None if code is None or code.startswith("en") else code)
