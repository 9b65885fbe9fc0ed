"""Timing tracks of xLights (.xtiming): layers of phrases, words and mouth shapes, in milliseconds."""

from __future__ import annotations

from xml.etree import ElementTree

from phonanim.readers._shapes import PRESTON_BLAIR, shape_phones
from phonanim.readers._xml import XML_DAMAGE, parse_xml
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "xLights timing track (.xtiming)"
MILLISECOND = 1e-3


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is the XML of timing tracks."""
    head = source.text[:2000]
    return "<timing" in head and "<EffectLayer" in source.text[:10_000]


def read(source: AlignmentFile) -> Recording:
    """For each track, the layer of mouth shapes as phones, and the layer of words."""
    try:
        root = parse_xml(source)
        tracks = [root] if root.tag == "timing" else list(root.iter("timing"))
        layered = [list(map(_layer, track.iter("EffectLayer"))) for track in tracks]
        names = [str(track.get("name") or "") for track in tracks]
    except XML_DAMAGE as error:
        raise source.error(f"is a damaged timing track ({error}); export it again") from error
    tiers: list[Tier] = []
    language: str = ""
    notes: tuple[str, ...] = ()
    for name, layers in zip(names, layered, strict=True):
        speaker = name if len(names) > 1 else ""
        for layer, kind in zip(layers, _kinds(layers), strict=True):
            if kind == "phones":
                layer, language, notes = shape_phones(layer)
            tiers.append(Tier(kind, layer, len(tiers) + 1, speaker))
    end = max((one.end for tier in tiers for one in tier.intervals), default=0.0)
    return Recording(tuple(tier for tier in tiers if tier.intervals), 0.0, end, notes, language, MILLISECOND)


def _layer(element: ElementTree.Element) -> tuple[Interval, ...]:
    intervals = []
    for effect in element.iter("Effect"):
        names = {name.lower(): value for name, value in effect.attrib.items()}
        start, end = (float(names[name]) * MILLISECOND for name in ("starttime", "endtime"))
        intervals.append(Interval(names.get("label", "").strip(), start, end))
    return tuple(intervals)


def _kinds(layers: list[tuple[Interval, ...]]) -> list[str]:
    """What each layer has. The program writes phrases, words and shapes in this order."""
    usual = {3: ["phrases", "words", "phones"], 2: ["phrases", "words"]}
    kinds = usual.get(len(layers), ["labels"] * len(layers))
    return [
        "phones" if layer and all(one.label.lower() in PRESTON_BLAIR for one in layer if one.label) else kind
        for layer, kind in zip(layers, kinds, strict=True)
    ]
