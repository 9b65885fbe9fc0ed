"""Projects of Papagayo-NG (.pg2), as JSON: voices, phrases, words, and mouth shapes at frames."""

from __future__ import annotations

from typing import Any

from phonanim.readers._rows import from_starts
from phonanim.readers._shapes import shape_phones
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Papagayo-NG project (.pg2)"
DEEPEST = 20  # levels of phrases and words


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with voices and a frame rate."""
    return isinstance(source.json, dict) and {"voices", "fps"} <= source.json.keys()


def read(source: AlignmentFile) -> Recording:
    """For each voice, its shapes as phones, and its words."""
    try:
        fps = float(source.json["fps"])
        voices = source.json["voices"]
        shapes = [_shapes(voice, fps) for voice in voices]
        words = [_words(voice, fps, 0) for voice in voices]
        names = [str(voice.get("name", "")) for voice in voices]
        end = float(source.json.get("sound_duration") or 0) / fps
    except DAMAGE as error:
        raise source.error(f"is a damaged project ({error!r}); save it again") from error
    _, language, notes = shape_phones(shape for voice in shapes for shape in voice)
    tiers: list[Tier] = []
    for name, phones, spoken in zip(names, shapes, words, strict=True):
        for kind, intervals in (("phones", shape_phones(phones)[0]), ("words", tuple(spoken))):
            if intervals:
                tiers.append(Tier(kind, intervals, len(tiers) + 1, name))
    end = max([end, *(one.end for tier in tiers for one in tier.intervals)])
    return Recording(tuple(tiers), 0.0, end, notes, language, 1 / fps)


def _shapes(voice: dict[str, Any], fps: float) -> tuple[Interval, ...]:
    """The shapes of a voice and of its words, each until the next; after the last word the mouth rests."""
    found = sorted(_frames(voice, 0), key=lambda pair: pair[0])
    if not found:
        return ()
    last = max(found[-1][0] + 1, int(voice.get("end_frame") or 0))
    starts = [(frame / fps, shape) for frame, shape in found]
    return tuple(one for one in from_starts(starts, last / fps) if one.end > one.start)


def _frames(node: dict[str, Any], depth: int) -> list[tuple[int, str]]:
    own = [(int(one["frame"]), str(one["text"])) for one in node.get("phonemes") or ()]
    inner = [pair for child in _children(node, depth) for pair in _frames(child, depth + 1)]
    if own and depth and node.get("end_frame") is not None:
        own.append((int(node["end_frame"]) + 1, "rest"))
    # A shape at the frame where a word ends replaces the rest there.
    return [*own, *inner]


def _words(node: dict[str, Any], fps: float, depth: int) -> list[Interval]:
    """The nodes with no nodes below them: their text and their first and last frame."""
    children = _children(node, depth)
    if children:
        return [word for child in children for word in _words(child, fps, depth + 1)]
    if not depth or node.get("start_frame") is None or node.get("end_frame") is None:
        return []
    start, last = int(node["start_frame"]), int(node["end_frame"])
    return [Interval(str(node.get("text", "")).strip(), start / fps, (last + 1) / fps)]


def _children(node: dict[str, Any], depth: int) -> list[dict[str, Any]]:
    found = node.get("children") or node.get("phrases") or node.get("words") or []
    return list(found) if depth < DEEPEST else []
