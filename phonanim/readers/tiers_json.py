"""TextGrid tiers as JSON, as the Montreal Forced Aligner and praatio write them."""

from __future__ import annotations

from typing import Any

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "TextGrid as JSON (MFA, praatio)"


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with tiers of entries."""
    tiers = source.json.get("tiers") if isinstance(source.json, dict) else None
    items = list(tiers.values()) if isinstance(tiers, dict) else tiers
    return (
        isinstance(items, list) and bool(items) and all(isinstance(t, dict) and "entries" in t for t in items)
    )


def read(source: AlignmentFile) -> Recording:
    """Every interval tier."""
    content = source.json
    tiers = content["tiers"]
    named = tiers.items() if isinstance(tiers, dict) else ((tier.get("name", ""), tier) for tier in tiers)
    try:
        found = [_tier(str(name), tier, number) for number, (name, tier) in enumerate(named, 1)]
        start = float(content.get("start", content.get("xmin", 0.0)))
        end = float(content.get("end", content.get("xmax", 0.0)))
    except DAMAGE as error:
        raise source.error(f"has a damaged tier ({error!r}); export it again") from error
    return Recording(tuple(tier for tier in found if tier), start, end)


def _tier(name: str, tier: dict[str, Any], number: int) -> Tier | None:
    if "interval" not in str(tier.get("type", tier.get("class", "interval"))).lower():
        return None
    intervals = (
        Interval(str(label).strip(), float(start), float(end)) for start, end, label in tier["entries"]
    )
    return Tier(name, tuple(intervals), number)
