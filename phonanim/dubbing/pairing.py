"""Which files of a folder are lines: alignments, and recordings with their transcripts."""

from __future__ import annotations

import os
import re
import unicodedata
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath

from phonanim.core.files import read_bounded
from phonanim.dubbing.storage import Place

# Suffixes that are used in a folder; a pattern or a table may name any, since readers detect the content.
ALIGNMENTS = (
    *(".textgrid", ".phn", ".lab", ".ctm", ".eaf", ".par", ".pgo", ".pg2", ".ds", ".ustx", ".pho", ".xra"),
    ".xtiming",
    ".utt",
    ".cha",
    ".anno",
    ".pam",
)
PLAIN = ".txt"  # a transcript where it stands beside a recording that has nothing else
TRANSCRIPT = ".lab"  # the Montreal Forced Aligner takes words from such files, HTK writes times into them
MOST = 64 << 10  # bytes of a transcript
_TIME = re.compile(r"\s*-?\d+(?:[.,]\d+)?\s")


def split_files(files: Sequence[Place]) -> tuple[list[Place], dict[Place, str], list[str]]:
    """The alignments of a folder, the transcripts of recordings that have none, and remarks.

    A `.lab` file without times is a transcript: beside an alignment of the same name it belongs to that line.
    So is a `.txt` file beside a recording without an alignment.
    """
    groups: dict[str, list[Place]] = {}
    for file in files:
        groups.setdefault(_plain(without_suffix(str(file))), []).append(file)
    alignments: list[Place] = []
    spoken: dict[Place, str] = {}
    passed = 0
    for group in groups.values():
        found = [file for file in group if file.suffix.lower() in ALIGNMENTS]
        if not found and (told := _plain_transcript(group)):
            spoken |= told
        timed = [file for file in found if file.suffix.lower() != TRANSCRIPT]
        for file in found:
            text = "" if file in timed else _transcript(file)
            if not text:
                alignments.append(file)
            elif timed:
                passed += 1
            elif recording := _recording(group):
                spoken[recording] = text
            else:
                alignments.append(file)
    remark = f"{passed} transcripts ({TRANSCRIPT}) beside alignments are not lines of their own"
    return sorted(alignments, key=str), spoken, [remark] if passed else []


def _plain(stem: str) -> str:
    return unicodedata.normalize("NFC", stem)


def _recording(group: Iterable[Place]) -> Place | None:
    """The recording of a group; that of a film where there is no other."""
    from phonanim.media.audio import RECORDINGS, SUFFIXES

    sounds = [file for file in group if file.suffix.lower() in RECORDINGS]
    return next((file for file in sounds if file.suffix.lower() in SUFFIXES), next(iter(sounds), None))


def _plain_transcript(group: Sequence[Place]) -> dict[Place, str]:
    """The recording of a group and its text in a plain file, if it has both."""
    texts = [text for file in group if file.suffix.lower() == PLAIN and (text := _transcript(file))]
    recording = _recording(group) if texts else None
    return {recording: texts[0]} if recording else {}


def _transcript(file: Place) -> str:
    """The text of a file without times, "" for any other file."""
    if not isinstance(file, Path) or not file.is_file() or file.stat().st_size > MOST:
        return ""
    try:
        text = read_bounded(file, MOST).decode("utf-8-sig").strip()
    except (OSError, ValueError):
        return ""
    rows = [line for line in text.splitlines() if line.strip()]
    timed = any(_TIME.match(row) or row.startswith(("#", '"')) for row in rows)
    return "" if timed or "\0" in text else " ".join(text.split())


def spellings(name: str) -> list[str]:
    """A path as it may be meant: as written, with slashes for backslashes, composed, decomposed."""
    if name.isascii() and "\\" not in name:
        return [name]
    found: dict[str, None] = {}
    for slashed in (name, name.replace("\\", "/")):
        composed = unicodedata.normalize("NFC", slashed)
        found |= dict.fromkeys((slashed, composed, unicodedata.normalize("NFD", slashed)))
    return list(found)


def without_suffix(name: str) -> str:
    """A path without the suffix that `pathlib` sees in it, at a fraction of the time."""
    head, dot, suffix = name.rpartition(".")
    plain = not dot or not suffix or "/" in suffix or os.sep in suffix or not head.strip(".")
    return name if plain or head.endswith(("/", os.sep)) else head


def stem_of(name: str) -> str:
    """The name of a file without its folder and suffix, of a path with slashes or backslashes."""
    return PurePosixPath(name.replace("\\", "/")).stem
