"""EMU annotation JSON: `_annot.json` of an emuDB, and `_bndl.json`, the exchange format of EMU-webApp."""

from __future__ import annotations

from typing import Any

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "EMU annotation JSON"


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with levels and a sample rate, bare or in a bundle."""
    annotation = _annotation(source)
    return isinstance(annotation, dict) and {"levels", "sampleRate"} <= annotation.keys()


def read(source: AlignmentFile) -> Recording:
    """Every level of segments, with sample numbers converted to seconds."""
    annotation = _annotation(source)
    try:
        rate = float(annotation["sampleRate"])
        levels = [level for level in annotation["levels"] if level["type"] == "SEGMENT"]
        tiers = tuple(_tier(level, rate, number) for number, level in enumerate(levels, 1))
    except DAMAGE as error:
        raise source.error(f"is a damaged EMU annotation ({error!r}); export it again") from error
    return Recording(tiers, 0.0, max((i.end for tier in tiers for i in tier.intervals), default=0.0))


def _annotation(source: AlignmentFile) -> Any:
    content = source.json
    return content.get("annotation", content) if isinstance(content, dict) else None


def _tier(level: dict[str, Any], rate: float, number: int) -> Tier:
    return Tier(str(level["name"]), tuple(_interval(item, rate) for item in level["items"]), number)


def _interval(item: dict[str, Any], rate: float) -> Interval:
    # Some writers count sampleDur up to the sample before the next segment, others up to that segment.
    # The gap of one sample is closed together with the other rounding gaps.
    start, length = float(item["sampleStart"]), float(item["sampleDur"])
    label = item["labels"][0]["value"] if item["labels"] else ""
    return Interval(str(label).strip(), start / rate, (start + length) / rate)
