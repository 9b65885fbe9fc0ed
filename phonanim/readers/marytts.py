"""MaryXML with acoustic parameters, as MaryTTS gives it: phones with durations, within tokens."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree.ElementTree import Element

from phonanim.readers._xml import XML_DAMAGE, parse_xml
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "MaryXML with phone durations (MaryTTS)"
LANGUAGE = "{http://www.w3.org/XML/1998/namespace}lang"


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is XML whose root is `maryxml`."""
    return "<maryxml" in source.text[:2000]


def read(source: AlignmentFile) -> Recording:
    """The phones in SAMPA and the tokens; `d` of a phone and `duration` of a boundary are milliseconds."""
    phones: list[Interval] = []
    words: list[Interval] = []
    try:
        root = parse_xml(source)
        time = 0.0
        for token, parts in _tokens(root):
            start = time
            for label, length in parts:
                phones.append(Interval(label, time, time + length))
                time += length
            if token:
                words.append(Interval(token, start, time))
    except XML_DAMAGE as error:
        raise source.error(f"is damaged MaryXML ({error}); synthesize it again") from error
    if not words:
        raise source.error("has no phones with durations; ask MaryTTS for REALISED_ACOUSTPARAMS")
    tiers = (Tier("words", tuple(words), 1), Tier("phones", tuple(phones), 2))
    return Recording(tiers, 0.0, time, unit=1e-3, spoken=root.get(LANGUAGE, ""))


def _tokens(root: Element) -> Iterator[tuple[str, list[tuple[str, float]]]]:
    """Each token with the phones and seconds in it, and each pause with no token."""
    for element in root.iter():
        name = element.tag.rpartition("}")[2]
        if name == "boundary" and (pause := element.get("duration")):
            yield "", [("_", _seconds(pause))]
        elif name == "t":
            parts = [
                (phone.attrib["p"], _seconds(phone.attrib["d"]))
                for phone in element.iter()
                if phone.tag.rpartition("}")[2] == "ph" and phone.get("d")
            ]
            if parts:
                yield " ".join((element.text or "").split()), parts


def _seconds(text: str) -> float:
    value = float(text) / 1000
    if not (math.isfinite(value) and value >= 0):
        raise ValueError(f"{text[:20]!r} is not a duration")
    return value
