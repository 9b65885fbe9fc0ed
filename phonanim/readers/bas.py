"""BAS Partitur files (.par, .bpf) of MAUS: tiers as keys, times in samples."""

from __future__ import annotations

import re

from phonanim.readers._rows import lines
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "BAS Partitur"

_ROW = re.compile(r"([A-Z]{3}):\s+(\d+)\s+(\d+)\s+(-?[\d,;-]+)\s+(.*)")


def recognizes(source: AlignmentFile) -> bool:
    """Whether the header declares a Partitur file."""
    return bool(re.match(r"LHD:\s*Partitur", source.text.lstrip()))


def read(source: AlignmentFile) -> Recording:
    """The tier MAU, and the words (ORT) with the times of their phones."""
    rate = re.search(r"^SAM:\s*(\d+)", source.text, re.MULTILINE)
    if not rate or float(rate[1]) == 0:
        raise source.error("has no sampling rate (SAM); export it again")
    rows = [match for line in lines(source) if (match := _ROW.fullmatch(line)) and match[1] == "MAU"]
    phones = [_interval(row, float(rate[1])) for row in rows]
    links = [row[4] for row in rows]
    spoken = dict(re.findall(r"^ORT:\s+(\d+)\s+(\S+)", source.text, re.MULTILINE))
    words = [
        Interval(word, times[0].start, times[-1].end)
        for link, word in spoken.items()
        if (times := [phone for phone, other in zip(phones, links, strict=True) if other == link])
    ]
    tiers = (Tier("MAU", tuple(phones), 1), Tier("ORT", tuple(words), 2))
    return Recording(tiers if phones else (), 0.0, phones[-1].end if phones else 0.0)


def _interval(row: re.Match[str], rate: float) -> Interval:
    # The duration excludes the first sample, so neighbours have a gap of one sample.
    start, length = float(row[2]), float(row[3]) + 1
    return Interval(row[5].strip(), start / rate, (start + length) / rate)
