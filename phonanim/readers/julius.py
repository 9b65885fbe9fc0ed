"""Output of Julius: the forced alignment of its log, in frames of 10 ms."""

from __future__ import annotations

import re

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "Julius forced alignment"
FRAME = 0.01  # seconds

_BEGIN, _END = "=== begin forced alignment ===", "=== end forced alignment ==="
_KIND = re.compile(r"-- (word|phoneme|state) alignment --")
_ROW = re.compile(r"\[\s*(\d+)\s+(\d+)\s*\]\s+(\S+)\s+(\S.*)")
_CENTRE = re.compile(r"(?:[^-+\s]*-)?([^-+\s]+)(?:\+\S*)?")


def recognizes(source: AlignmentFile) -> bool:
    """Whether a line of the log begins a forced alignment."""
    return _BEGIN in source.text


def read(source: AlignmentFile) -> Recording:
    """The phonemes and the words of the first sentence; a frame lasts up to the start of the next."""
    found: dict[str, list[Interval]] = {}
    kind = ""
    for line in source.text.partition(_BEGIN)[2].splitlines():
        if _END in line and "phoneme" in found:
            break
        if match := _KIND.search(line):
            kind = "" if match[1] in found else match[1]
            found.setdefault(match[1], [])
        elif (row := _ROW.search(line)) and kind:
            label = row[4].split("\t")[0].split()[0]
            centre = _CENTRE.fullmatch(label)
            text = centre[1] if kind == "phoneme" and centre else label
            found[kind].append(Interval(text, int(row[1]) * FRAME, (int(row[2]) + 1) * FRAME))
    tiers = [
        Tier(name, tuple(found[kind]), number)
        for number, (kind, name) in enumerate((("phoneme", "phones"), ("word", "words")), 1)
        if found.get(kind)
    ]
    if not tiers:
        raise source.error("has no phonemes in its forced alignment; run Julius with -palign")
    return Recording(tuple(tiers), 0.0, max(tier.intervals[-1].end for tier in tiers), unit=FRAME)
