"""Queries of VOICEVOX and AivisSpeech (`audio_query`): the lengths of each mora's consonant and vowel."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "VOICEVOX and AivisSpeech queries (JSON)"


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with accent phrases."""
    return isinstance(source.json, dict) and isinstance(source.json.get("accent_phrases"), list)


def read(source: AlignmentFile) -> Recording:
    """The phones, at the speed of the query; each mora is a word."""
    try:
        pieces = list(_pieces(source.json))
    except DAMAGE as error:
        raise source.error(f"has a damaged mora ({error!r}); query it again") from error
    phones: list[Interval] = []
    time = 0.0
    for label, length in pieces:
        phones.append(Interval(label, time, time + length))
        time += length
    if not any(one.end > one.start for one in phones if one.label != "pau"):
        raise source.error("has no lengths of phonemes; query `mora_data`, which gives them")
    return Recording((Tier("phones", tuple(phones)),), 0.0, time, language="japanese")


def _pieces(query: dict[str, Any]) -> Iterator[tuple[str, float]]:
    """Each phone with its length in seconds."""
    speed = float(query.get("speedScale", 1.0))
    pauses = float(query.get("pauseLengthScale") or 1.0)
    fixed = query.get("pauseLength")
    yield "pau", float(query.get("prePhonemeLength", 0.0)) / speed
    for phrase in query["accent_phrases"]:
        for mora in phrase["moras"]:
            if mora.get("consonant"):
                yield str(mora["consonant"]), float(mora.get("consonant_length") or 0.0) / speed
            yield str(mora["vowel"]), float(mora["vowel_length"]) / speed
        if pause := phrase.get("pause_mora"):
            length = float(pause["vowel_length"]) if fixed is None else float(fixed)
            yield "pau", length * pauses / speed
    yield "pau", float(query.get("postPhonemeLength", 0.0)) / speed
