"""Alignments that `phonanim animate --text` makes: of a recording, or of speech that eSpeak NG speaks."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from phonanim.errors import OptionError
from phonanim.speech.textgrid import write_textgrid

if TYPE_CHECKING:
    from phonanim.aligners.espeak import SpokenText
    from phonanim.commands import Console


def align_recording(recording: Path, text: str, voice: str | None, console: Console) -> Path:
    """Align a recording with its text, into a TextGrid beside it; notes are printed.

    In the language of `voice`, as IPA, or in English, as ARPAbet, when it is None. Raises OptionError if the
    TextGrid exists.
    """
    from phonanim.aligners.pocketsphinx import align
    from phonanim.aligners.warping import align_by_speech

    path = recording.with_suffix(".TextGrid")
    if path.exists():
        raise OptionError(f"{path}: is there already; animate it, or remove it to have it made from --text")
    found = align(recording, text) if voice is None else align_by_speech(recording, text, voice)
    for note in found.notes:
        console.print(f"note: {note}")
    write_textgrid(path, {"words": found.words, "phones": found.phones}, found.duration)
    return path


def speak_text(text: str, voice: str, beside: Path) -> Path:
    """Speak a text into `beside` with the suffixes .wav and .TextGrid, and return the TextGrid.

    The phones are in IPA. Files that speak this text already are left as they are. Raises OptionError when
    one of the two exists with other content.
    """
    from phonanim.aligners.espeak import speak

    spoken = speak(text, voice)
    sound, grid = beside.with_suffix(".wav"), beside.with_suffix(".TextGrid")
    with tempfile.TemporaryDirectory(prefix="phonanim-") as folder:
        for path in (sound, grid):
            fresh = Path(folder) / path.name
            _write(fresh, spoken)
            if path.exists() and path.read_bytes() != fresh.read_bytes():
                raise OptionError(
                    f"{path}: is there already, with other speech; choose another -o, or remove it"
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
