"""Align the lines that are given as a recording and its text."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from phonanim.aligners.pocketsphinx import align
from phonanim.dubbing.line import Line
from phonanim.dubbing.storage import Place
from phonanim.errors import OptionError
from phonanim.speech.labels import load_language
from phonanim.speech.textgrid import write_textgrid

SUFFIX = ".aligned.TextGrid"


def alignment_place(line: Line, folder: Place) -> Place:
    """The place of the alignment of a line, now or once it is made in `folder`."""
    return line.alignment if line.text is None else folder / f"{line.output}{SUFFIX}"


def align_line(line: Line, target: Path) -> None:
    """Align the recording of a line with its text. Raises OptionError for a language other than English."""
    language = line.options.language
    if language != "auto" and not load_language(language).code.startswith("en"):
        raise OptionError(
            f"{line.alignment}: text is aligned in English only, not in {language!r}; give an alignment "
            "(phonanim align --aligner mfa makes one)"
        )
    found = align(cast("Path", line.alignment), line.text)
    target.parent.mkdir(parents=True, exist_ok=True)
    write_textgrid(target, {"words": found.words, "phones": found.phones}, found.duration)
