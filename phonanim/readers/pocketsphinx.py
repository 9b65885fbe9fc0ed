"""Output of pocketsphinx: JSON with begin (b), duration (d) and text (t), or rows of a word and its times."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from phonanim.readers._rows import all_match, split
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "pocketsphinx output"

_ROW = re.compile(r"(\S+)\s+(\d+\.\d+)\s+(\d+\.\d+)\s+(-?\d+(?:\.\d+)?(?:e[-+]\d+)?)")
_VARIANT = re.compile(r"\(\d+\)$")


def recognizes(source: AlignmentFile) -> bool:
    """Whether each value is an utterance of this kind, or all rows are a word, its times and a confidence."""
    if source.json_lines:
        return all(
            isinstance(line, dict) and {"b", "d", "t", "w"} <= line.keys() for line in source.json_lines
        )
    rows = all_match(source, _ROW)
    return any(row[1] in ("<s>", "<sil>", "</s>") for row in rows)


def read(source: AlignmentFile) -> Recording:
    """The words, and the phones if the aligner was asked for them."""
    if not source.json_lines:
        rows = [Interval(_plain(m[1]), float(m[2]), float(m[3])) for m in split(source, _ROW)]
        return Recording((Tier("words", tuple(rows)),), 0.0, rows[-1].end)
    try:
        words = list(_items(source.json_lines))
        phones = [phone for line in source.json_lines for phone in _items(line["w"])]
        end = max(float(line["b"]) + float(line["d"]) for line in source.json_lines)
    except DAMAGE as error:
        raise source.error(f"has a damaged word ({error!r}); recognize again") from error
    tiers = [Tier("words", tuple(words), 1)]
    if phones:
        tiers.append(Tier("phones", tuple(phones), 2))
    return Recording(tuple(tier for tier in tiers if tier.intervals), 0.0, end)


def _items(lines: list[Any]) -> Iterator[Interval]:
    """The entries within each of these entries."""
    for line in lines:
        for item in line.get("w") or ():
            start = float(item["b"])
            yield Interval(_plain(str(item["t"])), start, start + float(item["d"]))


def _plain(text: str) -> str:
    return _VARIANT.sub("", text)
