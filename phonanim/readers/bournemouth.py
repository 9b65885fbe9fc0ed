"""JSON of the Bournemouth forced aligner: phonemes and words with times in milliseconds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from phonanim.readers._times import close_gaps
from phonanim.readers._words import first_value, tables
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Bournemouth forced aligner (JSON)"
MILLISECOND = 1e-3
GAP = 0.15
"""Seconds. The aligner marks where it is surest of a phone, so a gap up to this length is the phone's own."""


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with segments that have phoneme times."""
    return next(_segments(source.json_lines), None) is not None


def read(source: AlignmentFile) -> Recording:
    """The phones and the words."""
    try:
        phones = [
            _interval(item, ("ipa_label", "phoneme_label"))
            for segment in _segments(source.json_lines)
            for item in segment["phoneme_ts"]
        ]
        words = [
            _interval(item, ("word",))
            for segment in _segments(source.json_lines)
            for item in segment.get("words_ts") or ()
        ]
        ends = [float(segment.get("end") or 0.0) for segment in _segments(source.json_lines)]
    except DAMAGE as error:
        raise source.error(f"has a damaged phoneme ({error!r}); align again") from error
    tiers = (Tier("phones", close_gaps(phones, GAP), 1), Tier("words", close_gaps(words, GAP), 2))
    end = max([*ends, *(one.end for one in (*phones, *words))])
    return Recording(tuple(tier for tier in tiers if tier.intervals), 0.0, end, unit=MILLISECOND)


def _segments(content: list[Any]) -> Iterator[dict[str, Any]]:
    for part in tables(content):
        if isinstance(part.get("phoneme_ts"), list) and part["phoneme_ts"]:
            yield part


def _interval(item: dict[str, Any], names: tuple[str, ...]) -> Interval:
    label = str(first_value(item, names) or "").strip()
    return Interval(label, float(item["start_ms"]) * MILLISECOND, float(item["end_ms"]) * MILLISECOND)
