"""ELAN annotation files (.eaf)."""

from __future__ import annotations

from collections import defaultdict
from xml.etree import ElementTree

import numpy as np

from phonanim.readers._xml import XML_DAMAGE, parse_xml
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "ELAN"


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is the XML of an annotation document."""
    return "<ANNOTATION_DOCUMENT" in source.text[:4000]


def read(source: AlignmentFile) -> Recording:
    """Every tier with annotations; those without times share their parent's time equally."""
    try:
        root = parse_xml(source)
        document = _Document(root)
        tiers = tuple(document.tier(element, number) for number, element in enumerate(root.iter("TIER"), 1))
    except XML_DAMAGE as error:
        raise source.error(f"is a damaged ELAN file ({error}); save it again") from error
    end = max((interval.end for tier in tiers for interval in tier.intervals), default=0.0)
    return Recording(tuple(tier for tier in tiers if tier.intervals), 0.0, end)


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
