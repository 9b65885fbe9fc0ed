"""Timed text (TTML, DFXP): paragraphs and spans with times, as broadcasters exchange subtitles."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element

from phonanim.readers._cues import Cue, cue_recording
from phonanim.readers._xml import XML_DAMAGE, parse_xml
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "timed text (TTML, DFXP)"
LANGUAGE = "{http://www.w3.org/XML/1998/namespace}lang"
APPLE = "{http://music.apple.com/"
UNITS = {"h": 3600.0, "m": 60.0, "s": 1.0, "ms": 1e-3, "": 1.0}

_CLOCK = re.compile(r"(?:(\d+):)?(\d{1,2}):(\d{1,2})(?:([.:])(\d+))?")
_OFFSET = re.compile(r"(\d+(?:\.\d+)?)(h|ms|m|s|f|t|)")  # Apple writes seconds without a unit


class _Rates(NamedTuple):
    """Frames and ticks in a second, and whether times within an element count from the start of the file."""

    frames: float
    ticks: float
    absolute: bool = False


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is XML whose root is `tt`."""
    return bool(re.search(r"<(?:\w+:)?tt[\s>]", source.text[:2000]))


def read(source: AlignmentFile) -> Recording:
    """The words; those of a paragraph share its time by their letters, but where its spans have times."""
    try:
        root = parse_xml(source)
        frames = float(_attribute(root, "frameRate", "30"))
        rates = _Rates(frames, float(_attribute(root, "tickRate", str(frames))))
        rates = rates._replace(absolute=_is_absolute(root, rates))
        cues = list(_cues(root, 0.0, math.inf, rates))
    except XML_DAMAGE as error:
        raise source.error(f"is damaged timed text ({error}); save it again") from error
    return cue_recording(cues, root.get(LANGUAGE) or "")


def _cues(element: Element, start: float, end: float, rates: _Rates) -> Iterator[Cue]:
    """The paragraphs within an element; times count from those of the element around it."""
    start, end = _times(element, start, end, rates)
    if _name(element) == "p":
        spans = [child for child in element if _name(child) == "span" and child.get("begin")]
        if spans:
            pieces = [(start, element.text or "")]
            times = [_times(span, start, end, rates) for span in spans]
            following = [*(begin for begin, _ in times[1:]), math.inf]
            for span, (begin, last), after in zip(spans, times, following, strict=True):
                pieces.append((begin, _text(span)))
                pieces.append((min(last, max(after, begin)), span.tail or ""))
            yield _bounded(Cue(start, end, tuple(pieces)))
        else:
            yield _bounded(Cue(start, end, ((start, _text(element)),)))
        return
    for child in element:
        yield from _cues(child, start, end, rates)


def _is_absolute(root: Element, rates: _Rates) -> bool:
    """Whether times do not count from the element around them, as Apple writes: else they are outside it."""
    if any(key.startswith(APPLE) for key in root.attrib):
        return True
    for element in root.iter():
        start = _seconds(element.get("begin"), rates, 0.0)
        end = _seconds(element.get("end"), rates, math.inf)
        inner = [_seconds(child.get("begin"), rates, 0.0) for child in element if child.get("begin")]
        if start > 0 and any(start <= begin <= end < start + begin for begin in inner):
            return True
    return False


def _bounded(cue: Cue) -> Cue:
    """Raises ValueError for a paragraph that never ends."""
    last = max((time for time, _ in cue.pieces if math.isfinite(time)), default=cue.start)
    end = cue.end if math.isfinite(cue.end) else last
    if end <= cue.start and any(text.strip() for _, text in cue.pieces):
        raise ValueError(f"the paragraph at {cue.start:g} s has no end")
    pieces = tuple((min(time, end), text) for time, text in cue.pieces)
    return Cue(cue.start, end, pieces)


def _times(element: Element, start: float, end: float, rates: _Rates) -> tuple[float, float]:
    origin = 0.0 if rates.absolute else start
    begin = origin + _seconds(element.get("begin"), rates, start - origin)
    last = origin + _seconds(element.get("end"), rates, math.inf)
    return begin, min(last, begin + _seconds(element.get("dur"), rates, math.inf), end)


def _seconds(text: str | None, rates: _Rates, default: float) -> float:
    if text is None:
        return default
    if found := _CLOCK.fullmatch(text.strip()):
        whole = int(found[1] or 0) * 3600 + int(found[2]) * 60 + int(found[3])
        if found[4] == ":":
            return whole + int(found[5]) / rates.frames
        return whole + float(f"0.{found[5] or 0}")
    found = _OFFSET.fullmatch(text.strip())
    if not found:
        raise ValueError(f"{text[:20]!r} is not a time")
    unit = {**UNITS, "f": 1 / rates.frames, "t": 1 / rates.ticks}[found[2]]
    return float(found[1]) * unit


def _text(element: Element) -> str:
    """The text of an element; a line break is a blank."""
    parts = [element.text or ""]
    for child in element:
        parts += [" " if _name(child) == "br" else _text(child), child.tail or ""]
    return "".join(parts)


def _name(element: Element) -> str:
    return element.tag.rpartition("}")[2]


def _attribute(element: Element, name: str, default: str) -> str:
    return next((value for key, value in element.items() if key.rpartition("}")[2] == name), default)
