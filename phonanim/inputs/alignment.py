"""Read an alignment file: find its format, its phone tier and its words, and check its times."""

from __future__ import annotations

from pathlib import Path

from phonanim.readers import find_reader
from phonanim.speech.alignment import Alignment
from phonanim.speech.alignment_file import open_alignment_file


def read_alignment(
    path: Path, tier: str | None = None, speaker: str | None = None, lexicon: Path | str | None = None
) -> Alignment:
    """The phones of an alignment file, in any format of `phonanim.readers`.

    The phone tier is found by its name, else by its labels; `tier` chooses it by name or by number
    (from 1), `speaker` by who speaks. Where a file has words alone, `lexicon` is a pronunciation
    dictionary that spells them out. Raises AlignmentError with one line when the file cannot be read,
    no tier has phones, or times make no sense.
    """
    source = open_alignment_file(Path(path))
    recording = find_reader(source).read(source)
    return Alignment.from_recording(recording, source, tier, speaker, lexicon)
