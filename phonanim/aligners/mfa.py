"""Align speech with its text by the Montreal Forced Aligner, where it is installed, in any of its languages.

McAuliffe et al. (2017), "Montreal Forced Aligner: trainable text-speech alignment using Kaldi", Interspeech.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from phonanim.aligners.pocketsphinx import SpeechAlignment, split_words
from phonanim.errors import AlignmentError, MissingExtraError, OptionError
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import audio_duration
from phonanim.speech.alignment import Interval
from phonanim.speech.labels import is_silent

MODEL = "english_us_arpa"
UNKNOWN = ("spn", "<unk>")  # phone and word that replace a word that is not in the dictionary
TOLERANCE = 0.1  # seconds between the recording and its TextGrid

_STYLING = re.compile(r"\x1b\[[\d;]*[A-Za-z]|[\u2500-\u257f]")  # colours, and the boxes around errors


def align(
    audio: Path, text: str | None, model: str = MODEL, dictionary: str | None = None
) -> SpeechAlignment:
    """Find the words and phones of `text` in a recording by `mfa align_one`.

    `model` and `dictionary` are names of MFA models or paths; the default dictionary has the name of the
    model. Raises OptionError without text, MissingExtraError without `mfa`, AlignmentError with MFA's last
    line when it fails, and when its output is not an alignment of this text.
    """
    program = shutil.which("mfa")
    if program is None:
        raise MissingExtraError(
            "--aligner mfa needs the Montreal Forced Aligner: conda install -c conda-forge "
            "montreal-forced-aligner, and mfa on the PATH"
        )
    if text is None or not split_words(text):
        raise OptionError(
            "the Montreal Forced Aligner needs the spoken words; give them with --text or --text-file"
        )
    with tempfile.TemporaryDirectory(prefix="phonanim-mfa-") as name:
        said, grid = Path(name) / "speech.lab", Path(name) / "speech.TextGrid"
        said.write_text(" ".join(text.split()) + "\n", "utf-8")
        # --clean: MFA's cache is keyed by names, so it would not notice a changed dictionary.
        inputs = [str(audio.absolute()), str(said), dictionary or model, model, str(grid)]
        _run([program, "align_one", "--clean", *inputs], audio)
        return _read(grid, audio)


def _run(command: Sequence[str], audio: Path) -> None:
    environment = os.environ | {"NO_COLOR": "1", "COLUMNS": "400"}
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, encoding="utf-8", errors="replace"
    )
    if done.returncode:
        why = _last_line(done.stderr) or _last_line(done.stdout) or f"exit code {done.returncode}"
        raise AlignmentError(f"{audio}: the Montreal Forced Aligner failed: {why}")


def _last_line(output: str) -> str:
    """The last line that is not empty, without colours and boxes."""
    lines = ("".join(c for c in _STYLING.sub("", line) if c.isprintable()) for line in output.splitlines())
    return next((line.strip() for line in reversed(list(lines)) if re.search(r"\w", line)), "")


def _read(grid: Path, audio: Path) -> SpeechAlignment:
    """Read MFA's output and check that it is complete. Raises AlignmentError."""
    if not grid.is_file():
        raise AlignmentError(
            f"{audio}: the Montreal Forced Aligner wrote no TextGrid; run it by hand to see why"
        )
    try:
        found = read_alignment(grid)
    except AlignmentError as error:
        why = str(error).removeprefix(f"{grid}: ")
        raise AlignmentError(f"{audio}: the output of the Montreal Forced Aligner {why}") from error
    phones, words = _spoken(found.intervals), _spoken(found.words)
    seconds = audio_duration(audio)
    if abs(seconds - found.duration) > TOLERANCE:
        raise AlignmentError(
            f"{audio}: lasts {seconds:.2f} s, but the output of the Montreal Forced Aligner lasts "
            f"{found.duration:.2f} s; check that it can read the recording"
        )
    if not phones:
        raise AlignmentError(
            f"{audio}: the Montreal Forced Aligner found no phone; check that the text matches the audio"
        )
    _check_known(phones, words, audio)
    return SpeechAlignment(words, phones, found.duration)


def _spoken(tier: Sequence[Interval]) -> tuple[Interval, ...]:
    return tuple(interval for interval in tier if interval.label in UNKNOWN or not is_silent(interval.label))


def _check_known(phones: Sequence[Interval], words: Sequence[Interval], audio: Path) -> None:
    """Raise AlignmentError for a word that was aligned as noise because it has no pronunciation."""
    for phone in phones:
        if phone.label in UNKNOWN:
            middle = (phone.start + phone.end) / 2
            word = next((word.label for word in words if word.start <= middle < word.end), "?")
            raise AlignmentError(
                f"{audio}: the word {word!r} at {phone.start:.2f} s is not in the dictionary; "
                "add it to a dictionary of your own (--mfa-dictionary), or spell it as it sounds"
            )
