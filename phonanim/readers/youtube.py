"""Captions of YouTube as XML (srv1, srv2, srv3): texts with start and duration, and timed words."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element

from phonanim.readers._cues import Cue, cue_recording
from phonanim.readers._xml import XML_DAMAGE, parse_xml
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "captions of YouTube (XML)"
LONGEST = 0.6  # seconds of a line without a duration


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is XML whose root is `timedtext`, or `transcript` with texts."""
    head = source.text[:1000]
    return "<timedtext" in head or ("<transcript>" in head and "<text start=" in head)


def read(source: AlignmentFile) -> Recording:
    """The words; those of a line share its time by their letters, but where the file times them."""
    try:
        cues = list(_cues(parse_xml(source)))
    except XML_DAMAGE as error:
        raise source.error(f"has damaged captions ({error}); download them again") from error
    return cue_recording(cues)


def _cues(root: Element) -> Iterator[Cue]:
    for element in root.iter():
        if element.tag == "text":
            start = _seconds(element)
            yield Cue(start, start + _length(element), ((start, "".join(element.itertext())),))
        elif element.tag == "p" and element.get("a") is None:
            start = _seconds(element)
            pieces = [(start, element.text or "")]
            for word in element.findall("s"):
                pieces.append((start + float(word.get("t", "0")) / 1000, word.text or ""))
            yield Cue(start, start + _length(element), tuple(pieces))


def _seconds(element: Element) -> float:
    """The start: `start` is in seconds, `t` in milliseconds."""
    return float(element.attrib["start"]) if "start" in element.attrib else float(element.attrib["t"]) / 1000


def _length(element: Element) -> float:
    length = element.get("dur")
    return float(length) if length else float(element.get("d", LONGEST * 1000)) / 1000
