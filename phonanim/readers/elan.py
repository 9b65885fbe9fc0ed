"""ELAN annotation files (.eaf), and its tab-delimited text without a header."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np

from phonanim.readers._rows import all_match, split
from phonanim.readers._times import clock_seconds
from phonanim.readers._words import SPREAD, are_lines, spread_lines, word_recording
from phonanim.readers._xml import XML_DAMAGE, parse_xml
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "ELAN"

_CLOCK = r"\d{2}:\d{2}:\d{2}\.\d{3}"
_NUMBERS = r"(?:\t[\d.]+)*"
# Tier, participant, begin, end and often duration, each as clock time, as seconds, and as milliseconds.
_ROW = re.compile(
    rf"([^\t]*)\t(?:([^\t]*)\t)?({_CLOCK}){_NUMBERS}\t({_CLOCK}){_NUMBERS}(?:\t{_CLOCK}{_NUMBERS})?\t(.*)"
)


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is the XML of an annotation document, or all rows have two clock times behind a tier."""
    return "<ANNOTATION_DOCUMENT" in source.text[:4000] or bool(all_match(source, _ROW))


def read(source: AlignmentFile) -> Recording:
    """Every tier with annotations; those without times share their parent's time equally."""
    if "<ANNOTATION_DOCUMENT" not in source.text[:4000]:
        return _as_words(_from_rows(source))
    try:
        root = parse_xml(source)
        document = _Document(root)
        tiers = tuple(document.tier(element, number) for number, element in enumerate(root.iter("TIER"), 1))
    except XML_DAMAGE as error:
        raise source.error(f"is a damaged ELAN file ({error}); save it again") from error
    return _as_words([tier for tier in tiers if tier.intervals])


def _from_rows(source: AlignmentFile) -> list[Tier]:
    rows: dict[tuple[str, str], list[Interval]] = {}
    for match in split(source, _ROW, [line for line in source.text.splitlines() if line.strip()]):
        start, end = clock_seconds(match[3]), clock_seconds(match[4])
        rows.setdefault((match[1], match[2] or ""), []).append(Interval(match[5].strip(), start, end))
    return [
        Tier(name, tuple(sorted(found, key=lambda one: one.start)), number, speaker)
        for number, ((name, speaker), found) in enumerate(rows.items(), 1)
    ]


def _as_words(tiers: list[Tier]) -> Recording:
    """The tiers; where all are of lines of text, the words of each."""
    end = max((interval.end for tier in tiers for interval in tier.intervals), default=0.0)
    if not tiers or not all(are_lines(one.label for one in tier.intervals) for tier in tiers):
        return Recording(tuple(tiers), 0.0, end)
    several = len(tiers) > 1
    words = [
        replace(word, speaker=(tier.speaker or tier.name) if several else "")
        for tier in tiers
        for word in spread_lines(tier.intervals)
    ]
    return word_recording(words, end, (SPREAD,))


class _Document:
    """Time slots and annotations by their ids."""

    def __init__(self, root: ElementTree.Element) -> None:
        self.slots = _slots(root)
        self.spans = {
            element.attrib["ANNOTATION_ID"]: (
                self.slots[element.attrib["TIME_SLOT_REF1"]],
                self.slots[element.attrib["TIME_SLOT_REF2"]],
            )
            for element in root.iter("ALIGNABLE_ANNOTATION")
        }
        self.children: dict[tuple[str, str], list[str]] = defaultdict(list)
        for tier in root.iter("TIER"):
            for element in tier.iter("REF_ANNOTATION"):
                key = (tier.attrib["TIER_ID"], element.attrib["ANNOTATION_REF"])
                self.children[key].append(element.attrib["ANNOTATION_ID"])
        self.places = {
            child: (key, place)
            for key, children in self.children.items()
            for place, child in enumerate(children)
        }

    def tier(self, element: ElementTree.Element, number: int) -> Tier:
        """One tier, in time order."""
        intervals = [
            Interval(
                (item.findtext("ANNOTATION_VALUE") or "").strip(), *self.span(item.attrib["ANNOTATION_ID"], 0)
            )
            for annotation in element.iter("ANNOTATION")
            for item in annotation
        ]
        intervals.sort(key=lambda interval: interval.start)
        return Tier(element.attrib["TIER_ID"], tuple(intervals), number, element.get("PARTICIPANT", ""))

    def span(self, identity: str, depth: int) -> tuple[float, float]:
        """Start and end in seconds; a child has an equal share of its parent."""
        if identity in self.spans:
            return self.spans[identity]
        if depth > 20:
            raise ValueError("annotations refer to each other in a circle")
        key, place = self.places[identity]
        start, end = self.span(key[1], depth + 1)
        share = (end - start) / len(self.children[key])
        return start + place * share, start + (place + 1) * share


def _slots(root: ElementTree.Element) -> dict[str, float]:
    """Seconds of each time slot; slots without a time are spaced evenly between their neighbours."""
    names = [slot.attrib["TIME_SLOT_ID"] for slot in root.iter("TIME_SLOT")]
    values = [slot.get("TIME_VALUE") for slot in root.iter("TIME_SLOT")]
    known = [(n, float(value) / 1000) for n, value in enumerate(values) if value is not None]
    if not known:
        return {}
    places, times = zip(*known, strict=True)
    return dict(zip(names, np.interp(range(len(names)), places, times).tolist(), strict=True))
