"""EXMARaLDA transcriptions (.exb): events between points of a timeline, in tiers of speakers."""

from __future__ import annotations

from xml.etree.ElementTree import Element

import numpy as np

from phonanim.readers._xml import XML_DAMAGE, parse_xml
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "EXMARaLDA"


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is the XML of a basic transcription."""
    return "<basic-transcription" in source.text[:4000]


def read(source: AlignmentFile) -> Recording:
    """Every tier with events; points without a time are spaced evenly between their neighbours."""
    try:
        root = parse_xml(source)
        times = _timeline(root)
        tiers = [_tier(element, times, number) for number, element in enumerate(root.iter("tier"), 1)]
    except XML_DAMAGE as error:
        raise source.error(f"is a damaged transcription ({error!r}); save it again") from error
    end = max((one.end for tier in tiers for one in tier.intervals), default=0.0)
    return Recording(tuple(tier for tier in tiers if tier.intervals), 0.0, end)


def _timeline(root: Element) -> dict[str, float]:
    """Seconds of each point."""
    points = [(point.attrib["id"], point.get("time")) for point in root.iter("tli")]
    known = [(n, float(time)) for n, (_, time) in enumerate(points) if time is not None]
    if not known:
        raise ValueError("its timeline has no times")
    places, times = zip(*known, strict=True)
    names = [name for name, _ in points]
    return dict(zip(names, np.interp(range(len(names)), places, times).tolist(), strict=True))


def _tier(element: Element, times: dict[str, float], number: int) -> Tier:
    """A tier; one of what is said (type t) is of words, since its events may be utterances."""
    events = [
        Interval("".join(event.itertext()).strip(), times[event.attrib["start"]], times[event.attrib["end"]])
        for event in element.iter("event")
    ]
    events.sort(key=lambda event: event.start)
    name = element.get("category") or element.get("display-name") or ""
    spoken = element.get("type") == "t" and name.lower() in ("v", "txt", "sup", "")
    return Tier("words" if spoken else name, tuple(events), number, element.get("speaker", ""))
