"""Tokens of the synthesizer Kokoro, as JSON: words with their phonemes and times in seconds."""

from __future__ import annotations

from typing import Any

from phonanim.readers._ipa import split_sounds
from phonanim.readers._times import share
from phonanim.readers._words import first_value, tables
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Kokoro tokens with phonemes (JSON)"
NOTE = "the phones of each word share its time equally"
WORD, START, END = ("word", "text"), ("start_time", "start_ts", "start"), ("end_time", "end_ts", "end")


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with words that have a string of phonemes and a time."""
    return bool(_tokens(source))


def read(source: AlignmentFile) -> Recording:
    """The words and their phones in IPA; tokens without a time, such as punctuation, are left out."""
    words: list[Interval] = []
    phones: list[Interval] = []
    try:
        for token in _tokens(source):
            start, end = first_value(token, START), first_value(token, END)
            sounds = split_sounds(token["phonemes"])
            if start is None or end is None or not sounds:
                continue
            word = Interval(str(first_value(token, WORD)).strip(), float(start), float(end))
            words.append(word)
            phones += share(sounds, word.start, word.end)
    except DAMAGE as error:
        raise source.error(f"has a damaged token ({error!r}); synthesize it again") from error
    tiers = (Tier("words", tuple(words), 1), Tier("phones", tuple(phones), 2))
    return Recording(tiers, 0.0, max((word.end for word in words), default=0.0), (NOTE,))


def _tokens(source: AlignmentFile) -> list[dict[str, Any]]:
    return [
        table
        for table in tables(source.json_lines)
        if isinstance(table.get("phonemes"), str)
        and any(name in table for name in START)
        and any(name in table for name in WORD)
    ]
