"""Align the lines that are given as a recording and its text."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import cast

from phonanim.aligners.espeak import can_speak
from phonanim.aligners.pocketsphinx import align
from phonanim.aligners.warping import align_by_speech
from phonanim.dubbing.line import Line
from phonanim.dubbing.storage import Place
from phonanim.errors import OptionError
from phonanim.options import Options
from phonanim.speech.labels import load_language
from phonanim.speech.language_names import is_auto
from phonanim.speech.textgrid import write_textgrid

SUFFIX = ".aligned.TextGrid"


def alignment_place(line: Line, folder: Place) -> Place:
    """The place of the alignment of a line, now or once it is made in `folder`."""
    return line.alignment if line.text is None else folder / f"{line.output}{SUFFIX}"


def align_line(line: Line, target: Path) -> tuple[Options, tuple[str, ...]]:
    """Align the recording of a line with its text: the options with which to read the alignment, and notes.

    English is aligned by pocketsphinx. Other languages are aligned by speech of eSpeak NG, and their phones
    are IPA. Raises OptionError for another language without the extra `espeak`, and for one without a voice.
    """
    recording, text, options = cast("Path", line.alignment), str(line.text), line.options
    code = "en" if is_auto(options.language) else load_language(options.language).code
    if code.startswith("en"):
        found = align(recording, text)
    elif can_speak():
        found, options = align_by_speech(recording, text, code), replace(options, language="ipa")
    else:
        raise OptionError(
            f"{recording}: text in {options.language!r} is aligned by the extra espeak; pip install "
            "'phonanim[espeak]', or give an alignment (phonanim align --aligner mfa makes one)"
        )
    target.parent.mkdir(parents=True, exist_ok=True)
    write_textgrid(target, {"words": found.words, "phones": found.phones}, found.duration)
    return options, found.notes
