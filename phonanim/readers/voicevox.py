"""Queries of VOICEVOX, AivisSpeech and COEIROINK: the lengths of each mora's consonant and vowel.

Also their accent phrases alone, VOICEVOX projects (.vvproj), queries of songs, and COEIROINK's durations.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "VOICEVOX, AivisSpeech and COEIROINK queries (JSON)"
SONG_RATE = 93.75
"""Frames per second of a song: 24000 samples in pieces of 256."""

SAMPLES = 44_100
"""Samples per second that COEIROINK counts in."""

ASSUMED = f"the file has no sample rate; {SAMPLES} per second assumed"
Piece = tuple[str, float]


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with accent phrases, or with phonemes in frames or in ranges of samples."""
    try:
        return bool(_queries(source.json))
    except DAMAGE:
        return True


def read(source: AlignmentFile) -> Recording:
    """The phones of each line, at the speed of the query."""
    tiers: list[Tier] = []
    try:
        queries = _queries(source.json)
        for number, (name, query) in enumerate(queries, 1):
            phones = _phones(_pieces(query))
            speaker = f"{number} {name}".strip() if len(queries) > 1 else ""
            if any(one.end > one.start for one in phones if one.label != "pau"):
                tiers.append(Tier("phones", phones, number, speaker))
    except DAMAGE as error:
        raise source.error(f"has a damaged mora ({error!r}); query it again") from error
    if not tiers:
        raise source.error("has no lengths of phonemes; query `mora_data`, which gives them")
    notes = (ASSUMED,) if any("moraDurations" in query for _, query in queries) else ()
    end = max(tier.intervals[-1].end for tier in tiers)
    return Recording(tuple(tiers), 0.0, end, notes, language="japanese")


def _queries(content: Any) -> list[tuple[str, dict[str, Any]]]:
    """The lines of a file: the text and the query of each."""
    if isinstance(content, list) and content and all(_has(item, "moras") for item in content):
        return [("", {"accent_phrases": content})]
    if not isinstance(content, dict):
        return []
    if isinstance(talk := content.get("talk"), dict):
        items = talk["audioItems"]
        ordered = [items[key] for key in talk.get("audioKeys") or items]
        return [(str(item.get("text", "")), item["query"]) for item in ordered if item.get("query")]
    sung = content.get("phonemes")
    if isinstance(sung, list) and sung and all(_has(item, "frame_length") for item in sung):
        return [("", content)]
    if isinstance(content.get("moraDurations"), list) or isinstance(_get(content, "accent_phrases"), list):
        return [("", content)]
    return []


def _phones(pieces: Iterator[Piece]) -> tuple[Interval, ...]:
    phones: list[Interval] = []
    time = 0.0
    for label, length in pieces:
        phones.append(Interval(label, time, time + length))
        time += length
    return tuple(phones)


def _pieces(query: dict[str, Any]) -> Iterator[Piece]:
    """Each phone with its length in seconds."""
    if "moraDurations" in query:
        for mora in query["moraDurations"]:
            for part in mora["phonemePitches"]:
                span = part["wavRange"]
                yield str(part["phoneme"]), (float(span["end"]) - float(span["start"])) / SAMPLES
    elif _get(query, "accent_phrases") is None:
        for part in query["phonemes"]:
            yield str(part["phoneme"]), float(_get(part, "frame_length")) / SONG_RATE
    else:
        yield from _spoken(query)


def _spoken(query: dict[str, Any]) -> Iterator[Piece]:
    speed = float(query.get("speedScale", 1.0))
    pauses = float(query.get("pauseLengthScale") or 1.0)
    fixed = query.get("pauseLength")
    yield "pau", float(query.get("prePhonemeLength", 0.0)) / speed
    for phrase in _get(query, "accent_phrases"):
        for mora in phrase["moras"]:
            if mora.get("consonant"):
                yield str(mora["consonant"]), float(_get(mora, "consonant_length") or 0.0) / speed
            yield str(mora["vowel"]), float(_get(mora, "vowel_length")) / speed
        if pause := _get(phrase, "pause_mora"):
            length = float(_get(pause, "vowel_length")) if fixed is None else float(fixed)
            yield "pau", length * pauses / speed
    yield "pau", float(query.get("postPhonemeLength", 0.0)) / speed


def _get(table: dict[str, Any], name: str) -> Any:
    """A field by its name in either of the spellings accent_phrases and accentPhrases."""
    first, *others = name.split("_")
    return table.get(name, table.get(first + "".join(map(str.capitalize, others))))


def _has(item: Any, name: str) -> bool:
    return isinstance(item, dict) and _get(item, name) is not None
