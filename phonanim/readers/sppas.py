"""Annotations of SPPAS (.xra): tiers of annotations with a location and labels of scored tags."""

from __future__ import annotations

from xml.etree import ElementTree

from phonanim.readers._xml import XML_DAMAGE, parse_xml
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "SPPAS annotations (.xra)"
NAMES = {"phonalign": "phones", "tokensalign": "words", "phones": "phones"}
"""What the program calls its tiers of phones and words."""


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is the XML of a SPPAS document."""
    head = source.text[:2000]
    return "<Document" in head and ("xra" in head or "<Tier" in source.text[:20_000])


def read(source: AlignmentFile) -> Recording:
    """Every tier of intervals; of a label's tags, the one with the highest score."""
    try:
        tiers = [_tier(element, number) for number, element in enumerate(parse_xml(source).iter("Tier"), 1)]
    except XML_DAMAGE as error:
        raise source.error(f"is a damaged SPPAS file ({error}); save it again") from error
    kept = tuple(tier for tier in tiers if tier.intervals)
    return Recording(kept, 0.0, max((one.end for tier in kept for one in tier.intervals), default=0.0))


def _tier(element: ElementTree.Element, number: int) -> Tier:
    name = str(element.get("tiername") or element.get("name") or element.get("id") or "")
    found = [_interval(annotation) for annotation in element.iter("Annotation")]
    return Tier(NAMES.get(name.lower(), name), tuple(one for one in found if one), number)


def _interval(annotation: ElementTree.Element) -> Interval | None:
    """An annotation, None for one at a point."""
    begin, end = annotation.find(".//Begin"), annotation.find(".//End")
    if begin is None and end is None:
        return None
    if begin is None or end is None:
        raise ValueError("an interval has no begin or no end")
    texts = [_best(label) for label in annotation.iter("Label")]
    label = " ".join(text for text in texts if text)
    return Interval(label, float(begin.attrib["midpoint"]), float(end.attrib["midpoint"]))


def _best(label: ElementTree.Element) -> str:
    tags = list(label.iter("Tag")) or list(label.iter("Text"))
    best = max(tags, key=lambda tag: float(tag.get("score") or 0.0), default=label)
    return (best.text or "").strip()
