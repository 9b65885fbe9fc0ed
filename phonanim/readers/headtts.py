"""Speech of HeadTTS and TalkingHead, as JSON: lists of visemes and words with times in milliseconds."""

from __future__ import annotations

from typing import Any

from phonanim.readers._visemes import NOTE, merge_repeats, oculus_phone
from phonanim.readers._words import tables
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "HeadTTS and TalkingHead speech (JSON)"
MILLISECOND = 1e-3


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with lists of visemes or words and of their times."""
    return _speech(source) is not None


def read(source: AlignmentFile) -> Recording:
    """The visemes as the phones that they stand for, and the words."""
    speech = _speech(source) or {}
    try:
        visemes = [
            Interval(oculus_phone(one.label), one.start, one.end)
            for one in _intervals(speech, "visemes", "vtimes", "vdurations")
        ]
        words = _intervals(speech, "words", "wtimes", "wdurations")
    except DAMAGE as error:
        raise source.error(f"has damaged times ({error!r}); synthesize it again") from error
    tiers = []
    if visemes:
        tiers.append(Tier("phones", merge_repeats(visemes), 1))
    if words:
        tiers.append(Tier("words", tuple(words), 2))
    end = max((one.end for one in (*visemes, *words)), default=0.0)
    notes, language = ((NOTE,), "english") if visemes else ((), "")
    return Recording(tuple(tiers), 0.0, end, notes, language, MILLISECOND)


def _speech(source: AlignmentFile) -> dict[str, Any] | None:
    for table in tables(source.json_lines):
        if any(isinstance(table.get(name), list) and table[name] for name in ("vtimes", "wtimes")):
            return table
    return None


def _intervals(speech: dict[str, Any], labels: str, starts: str, lasts: str) -> list[Interval]:
    texts, times, lengths = (speech.get(name) or [] for name in (labels, starts, lasts))
    if not len(texts) == len(times) == len(lengths):
        raise ValueError(f"{len(texts)} {labels}, {len(times)} {starts} and {len(lengths)} {lasts}")
    return [
        Interval(str(text).strip(), float(start) * MILLISECOND, (float(start) + float(length)) * MILLISECOND)
        for text, start, length in zip(texts, times, lengths, strict=True)
    ]
