"""Mouth cues of Rhubarb Lip Sync: TSV, XML or JSON, shapes A to H and X."""

from __future__ import annotations

import re

from phonanim.readers._rows import all_match, from_starts, split
from phonanim.readers._xml import XML_DAMAGE, parse_xml
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "Rhubarb mouth cues"

_ROW = re.compile(r"(\d+(?:\.\d+)?)\t([A-HX])")


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON or XML with mouth cues, or rows of a time and a shape."""
    if isinstance(source.json, dict):
        cues = source.json.get("mouthCues")
        return isinstance(cues, list) and not any(map(_is_of_another, cues))
    return "<rhubarbResult" in source.text[:500] or bool(all_match(source, _ROW))


def _is_of_another(cue: object) -> bool:
    """Whether a cue has the name or the number of a viseme, as avatars on the web write them."""
    value = cue.get("value") if isinstance(cue, dict) else None
    return isinstance(value, int) or (isinstance(value, str) and value.lower().startswith("viseme"))


def read(source: AlignmentFile) -> Recording:
    """The cues, in the language `rhubarb`, which maps each shape to the sounds that it shows."""
    try:
        cues = _cues(source)
    except XML_DAMAGE as error:
        raise source.error(f"has a damaged cue ({error!r}); export it again") from error
    notes = ("mouth shapes are used as phones, because the file does not contain the sounds",)
    end = max((cue.end for cue in cues), default=0.0)
    return Recording((Tier("phones", tuple(cues)),), 0.0, end, notes=notes, language="rhubarb")


def _cues(source: AlignmentFile) -> tuple[Interval, ...]:
    if source.json is not None:
        cues = source.json["mouthCues"]
        return tuple(Interval(str(cue["value"]), float(cue["start"]), float(cue["end"])) for cue in cues)
    if source.text.lstrip().startswith("<"):
        found = parse_xml(source).iter("mouthCue")
        return tuple(
            Interval(cue.text or "", float(cue.attrib["start"]), float(cue.attrib["end"])) for cue in found
        )
    starts = [(float(match[1]), match[2]) for match in split(source, _ROW)]
    # The last row gives the start of the final rest, not its length.
    return from_starts(starts, starts[-1][0] + 0.1)
