"""Transcriber (.trs): turns of speakers whose text is cut by points of time."""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element

from phonanim.readers._cues import Cue, cue_recording, plain_cue
from phonanim.readers._xml import XML_DAMAGE, parse_xml
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "Transcriber (.trs)"

_DOCTYPE = re.compile(r"<!DOCTYPE\s+Trans\s+SYSTEM\s+\"[\w.-]+\"\s*>")


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is the XML of a transcription."""
    return bool(re.search(r"<Trans[\s>]", source.text[:4000]))


def read(source: AlignmentFile) -> Recording:
    """The words of each speaker; those between two points share the time by their letters."""
    try:
        # The name of its grammar, which every file has, declares nothing.
        root = parse_xml(source, _DOCTYPE.sub("", source.text, 1))
        names = {speaker.get("id", ""): speaker.get("name", "") for speaker in root.iter("Speaker")}
        cues = [cue for turn in root.iter("Turn") for cue in _cues(turn, names)]
    except XML_DAMAGE as error:
        raise source.error(f"is a damaged transcription ({error!r}); save it again") from error
    return cue_recording(cues, root.get("{http://www.w3.org/XML/1998/namespace}lang") or "")


def _cues(turn: Element, names: dict[str, str]) -> Iterator[Cue]:
    speaker = turn.get("speaker", "").split(" ")[0]
    points: list[tuple[float, list[str]]] = [(float(turn.attrib["startTime"]), [turn.text or ""])]
    for element in turn:
        if element.tag == "Sync":
            points.append((float(element.attrib["time"]), []))
        points[-1][1].append(element.tail or "")
    ends = [*(time for time, _ in points[1:]), float(turn.attrib["endTime"])]
    for (start, texts), end in zip(points, ends, strict=True):
        yield plain_cue(start, end, " ".join(texts), names.get(speaker) or speaker)
