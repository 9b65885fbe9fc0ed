"""JSON of Azure's speech service: recognized words, and the phonemes of a pronunciation assessment."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from phonanim.readers._times import close_gaps
from phonanim.readers._words import tables
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Azure speech results (JSON)"
TICK = 1e-7  # seconds: the service counts 100 ns
ASSESSED = "privPronJson"
"""Where the SDK for JavaScript keeps the words of an assessment."""

REST = 0.0101  # seconds by which its durations fall short of the next start


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with alternatives (NBest) of words that have an offset."""
    return next(_words(source.json_lines), None) is not None


def read(source: AlignmentFile) -> Recording:
    """The words and, if they were assessed, the phonemes of the first alternative of each result."""
    try:
        words = [_interval(word, word.get("Word", "")) for word in _words(source.json_lines)]
        phones = [
            _interval(phone, phone["Phoneme"])
            for word in _words(source.json_lines)
            for phone in word.get("Phonemes") or ()
        ]
    except DAMAGE as error:
        raise source.error(f"has a damaged word ({error!r}); save the result again") from error
    tiers = [Tier("words", close_gaps(words, REST), 1)]
    if phones:
        tiers.append(Tier("phones", close_gaps(phones, REST), 2))
    return Recording(tuple(tiers), 0.0, max(one.end for one in (*words, *phones)), unit=TICK)


def _words(lines: list[Any]) -> Iterator[dict[str, Any]]:
    for table in tables(lines):
        best = table.get("NBest") or table.get("nBest") or [table.get(ASSESSED)]
        first = best[0] if isinstance(best, list) and best else None
        words = first.get("Words") if isinstance(first, dict) else None
        for word in words if isinstance(words, list) else ():
            if isinstance(word, dict) and "Offset" in word:
                yield word


def _interval(item: dict[str, Any], label: Any) -> Interval:
    start = float(item["Offset"])
    return Interval(str(label).strip(), start * TICK, (start + float(item["Duration"])) * TICK)
