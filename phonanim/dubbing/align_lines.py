"""Lines that have no alignment yet: recordings with their text are aligned, text alone is spoken."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from phonanim.aligners.espeak import VOICE, can_speak, reading_language, speak, write_speech
from phonanim.aligners.long import align_recording
from phonanim.core.files import make_folder_within
from phonanim.dubbing.line import Line
from phonanim.dubbing.storage import Place
from phonanim.errors import OptionError
from phonanim.options import Options
from phonanim.readers import LINES
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import is_auto, one_expected
from phonanim.speech.textgrid import write_textgrid

SUFFIX = ".aligned.TextGrid"
SOUND = ".wav"
SPOKEN = "there is no recording: spoken by eSpeak NG"  # begins the note of such a line


@dataclass(frozen=True, slots=True)
class Prepared:
    """What a line is animated from, how to read it, notes, and the files that were made for it."""

    alignment: Path
    audio: Path | None
    options: Options
    notes: tuple[str, ...] = ()
    made: tuple[Path, ...] = ()


def made_suffixes(line: Line) -> tuple[str, ...]:
    """The suffixes of the files that are made for a line, or may be, besides its outputs."""
    if line.text is None:
        return (SUFFIX,) if has_timed_lines(line) else ()
    return (SUFFIX, SOUND) if line.is_spoken else (SUFFIX,)


def has_timed_lines(line: Line) -> bool:
    """Whether a line has a recording and a file that may give times to lines of text, such as subtitles."""
    source = line.alignment
    return line.audio is not None and source is not None and source.suffix.lower() in LINES


def alignment_place(line: Line, folder: Place) -> Place:
    """The place of the alignment of a line, now or once it is made in `folder`."""
    made = folder / f"{line.output}{SUFFIX}"
    if line.text is None and line.alignment is not None:
        return made if has_timed_lines(line) and made.is_file() else line.alignment
    return made


def sound_place(line: Line, folder: Place) -> Place | None:
    """The place of the recording of a line, now or once its text is spoken in `folder`."""
    return folder / f"{line.output}{SOUND}" if line.is_spoken else line.audio


def prepare_line(line: Line, folder: Path) -> Prepared:
    """Align or speak a line in `folder`, if it needs that. Raises PhonanimError."""
    audio = cast("Path | None", sound_place(line, folder))
    target = folder / f"{line.output}{SUFFIX}"
    if line.text is None:
        given = Prepared(cast("Path", line.alignment), audio, line.options)
        if not has_timed_lines(line):
            return given
        make_folder_within(target.parent, folder)
        return _with_lines_aligned(given, target)
    make_folder_within(target.parent, folder)
    if line.is_spoken:
        options, notes = speak_line(line, target, cast("Path", audio))
        return Prepared(target, audio, options, notes, (target, cast("Path", audio)))
    options, notes = align_line(line, target)
    return Prepared(target, audio, options, notes, (target,))


def _with_lines_aligned(given: Prepared, target: Path) -> Prepared:
    """A line whose file gives times to lines of text, aligned within each of them; else as it is."""
    from phonanim.aligners.cues import align_cues

    target.unlink(missing_ok=True)  # of an earlier run
    aligned = align_cues(given.alignment, cast("Path", given.audio), given.options)
    if aligned is None:
        return given
    found, language = aligned
    write_textgrid(target, found.tiers, found.duration)
    options = replace(given.options, language=language)
    return Prepared(target, given.audio, options, found.notes, (target,))


def voice_of(line: Line) -> str:
    """The voice of a line that is spoken: its own, or that of its language, or English."""
    if line.voice:
        return line.voice
    language = line.options.language
    named = one_expected(language) if is_auto(language) else language
    code = load_language(named).code if named else ""
    return VOICE if not code or code.startswith("en") else code


def speak_line(line: Line, target: Path, sound: Path) -> tuple[Options, tuple[str, ...]]:
    """Speak the text of a line into a TextGrid and its sound: how to read the TextGrid, and notes."""
    voice = voice_of(line)
    spoken = speak(str(line.text), voice)
    write_speech(sound, spoken)
    write_textgrid(target, {"words": spoken.words, "phones": spoken.phones}, spoken.duration)
    note = f"{SPOKEN} with the voice {voice}"
    return replace(line.options, language=reading_language(voice)), (note, *spoken.notes)


def align_line(line: Line, target: Path) -> tuple[Options, tuple[str, ...]]:
    """Align the recording of a line with its text: the options with which to read the alignment, and notes.

    English is aligned by pocketsphinx. Other languages are aligned by speech of eSpeak NG. Raises OptionError
    for another language without the extra `espeak`, and for one without a voice.
    """
    recording, text, options = cast("Path", line.alignment), str(line.text), line.options
    code = _language_code(line)
    if not code.startswith("en") and not can_speak():
        raise OptionError(
            f"{recording}: text in {options.language!r} is aligned by the extra espeak; pip install "
            "'phonanim[espeak]', or give an alignment (phonanim align --aligner mfa makes one)"
        )
    found, _ = align_recording(recording, text, None if code.startswith("en") else code)
    write_textgrid(target, found.tiers, found.duration)
    return aligned_options(line), found.notes


def aligned_options(line: Line) -> Options:
    """The options with which to read the alignment that is made for a line with text."""
    if line.is_spoken:
        return replace(line.options, language=reading_language(voice_of(line)))
    code = _language_code(line)
    return line.options if code.startswith("en") else replace(line.options, language=reading_language(code))


def _language_code(line: Line) -> str:
    """The code of the language of a recording with its text."""
    language = line.options.language
    return line.voice or ("en" if is_auto(language) else load_language(language).code)
