"""Scripts of DiffSinger (.ds), as JSON: phonemes with their durations, and the offset of each line."""

from __future__ import annotations

from typing import Any

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "DiffSinger script (.ds)"


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with sequences of phonemes."""
    return bool(_lines(source)) and all(
        isinstance(line, dict) and "ph_seq" in line for line in _lines(source)
    )


def read(source: AlignmentFile) -> Recording:
    """The phonemes. A label such as "zh/a" names its language before the slash."""
    phones: list[Interval] = []
    try:
        first = min(float(line.get("offset", 0.0)) for line in _lines(source))
        for line in _lines(source):
            if "ph_dur" not in line:
                raise ValueError("it has no ph_dur")
            time = float(line.get("offset", 0.0))
            names, lengths = str(line["ph_seq"]).split(), str(line["ph_dur"]).split()
            if len(names) != len(lengths):
                raise ValueError(f"{len(names)} phonemes and {len(lengths)} durations")
            for name, length in zip(names, map(float, lengths), strict=True):
                phones.append(Interval(name.rpartition("/")[2] or name, time, time + length))
                time += length
        end = max(one.end for one in phones)
    except DAMAGE as error:
        raise source.error(f"has a damaged line ({error}); export it with its durations") from error
    return Recording((Tier("phones", tuple(phones)),), first, end)


def _lines(source: AlignmentFile) -> list[Any]:
    content = source.json
    return content if isinstance(content, list) else [content] if isinstance(content, dict) else []
