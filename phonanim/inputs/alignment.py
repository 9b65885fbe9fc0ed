"""Read an alignment file: find its format, its phone tier and its words, and check its times."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from phonanim.errors import AudioError, MissingExtraError
from phonanim.readers import read_recording
from phonanim.speech.alignment import Alignment
from phonanim.speech.alignment_file import open_alignment_file
from phonanim.speech.clock import Clock
from phonanim.speech.doubts import recorded_doubts


def read_alignment(
    path: str | Path,
    tier: str | None = None,
    speaker: str | None = None,
    lexicon: str | Path | None = None,
    unknown: str = "error",
    language: str = "auto",
    unit: str | None = None,
    offset: float | None = None,
    audio: str | Path | None = None,
) -> Alignment:
    """Read the phones of an alignment file, in any format that `phonanim info` lists.

    Args:
        path: The file; its format is detected by its content.
        tier: The phone tier, by name or by number from 1. Without it the tier is found by its name, else by
            its labels.
        speaker: The speaker, for a file of several speakers.
        lexicon: A pronunciation dictionary, for a file with words only. Without it, English words are
            looked up in the CMU dictionary of an installed package.
        unknown: What happens to a word that cannot be spelled: error, nearest or silence.
        language: The language of words; auto takes what the file says, else English.
        unit: The unit of the file's times, such as ms or samples@16000; by default that of its format.
        offset: The time in seconds that is 0 of the animation; by default 0, or where a later part starts.
        audio: The recording. Where units or starts are in doubt, its length decides, with a note.

    Raises:
        AlignmentError: The file cannot be read, no tier has phones, or its times are inconsistent.

    Examples:
        >>> import phonanim
        >>> alignment = phonanim.read_alignment("line.TextGrid")
        >>> alignment.intervals[1].label
        'M'
    """
    source = open_alignment_file(Path(path))
    clock = Clock(unit, offset, _length(audio))
    recording = read_recording(source)
    recording = replace(recording, notes=(*recording.notes, *recorded_doubts(recording)))
    return Alignment.from_recording(recording, source, tier, speaker, lexicon, unknown, language, clock)


def _length(audio: str | Path | None) -> float | None:
    """Seconds of a recording by its header; None without a recording that can be read."""
    if audio is None:
        return None
    from phonanim.media.audio import audio_duration

    try:
        return audio_duration(Path(audio))
    except (AudioError, MissingExtraError):
        return None
