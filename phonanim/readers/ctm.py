"""CTM of NIST and Kaldi: utterance, channel, start, duration, label and often a confidence."""

from __future__ import annotations

import re

from phonanim.readers._rows import all_match, lines, split
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "CTM"

_NUMBER = r"\d+(?:\.\d*)?"
_ROW = re.compile(rf"(\S+)\s+(\w+)\s+({_NUMBER})\s+({_NUMBER})\s+(\S+)(?:\s+-?{_NUMBER})?(?:\s+\S+){{0,2}}")


def recognizes(source: AlignmentFile) -> bool:
    """Whether all rows have these columns; comments begin with two semicolons."""
    return bool(all_match(AlignmentFile(source.name, source.stem, "\n".join(_rows(source)).encode()), _ROW))


def read(source: AlignmentFile) -> Recording:
    """One tier for each utterance and channel, which are used as speakers."""
    tracks: dict[str, list[Interval]] = {}
    for match in split(source, _ROW, _rows(source)):
        start, length = float(match[3]), float(match[4])
        # CTM rounds times to 10 ms each, so neighbours may be that far apart.
        track = tracks.setdefault(f"{match[1]} {match[2]}", [])
        if track and abs(track[-1].end - start) < 0.0101 and start > track[-1].start:
            track[-1] = Interval(track[-1].label, track[-1].start, start)
        track.append(Interval(re.sub("_[BIES]$", "", match[5]), start, start + length))
    tiers = [Tier("labels", tuple(track), n, name) for n, (name, track) in enumerate(tracks.items(), 1)]
    return Recording(tuple(tiers), 0.0, max(tier.intervals[-1].end for tier in tiers))


def _rows(source: AlignmentFile) -> list[str]:
    return [line for line in lines(source) if not line.startswith(";;")]
