"""Praat TextGrids with praatio: convert tiers to its objects and back, and write files.

praatio is imported only when a TextGrid is made: reading one, as most commands do, does not need it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from phonanim.core.files import atomic_path
from phonanim.errors import OutputError
from phonanim.speech.intervals import Interval, Recording, Tier

if TYPE_CHECKING:
    from praatio.data_classes.textgrid import Textgrid


def write_textgrid(path: Path, tiers: Mapping[str, Sequence[Interval]], duration: float) -> None:
    """Write interval tiers from 0 to `duration` seconds in Praat's long text format, atomically.

    Gaps are filled with empty labels. Raises OutputError when intervals overlap, or when the file cannot be
    written.
    """
    from praatio.utilities.errors import PraatioException

    try:
        textgrid = textgrid_from(tiers, 0.0, duration)
    except PraatioException as error:
        reason = " ".join(str(error).split())
        raise OutputError(f"{path}: cannot be written as a TextGrid: {reason}; correct the times") from error
    with atomic_path(path) as partial:
        textgrid.save(str(partial), "long_textgrid", includeBlankSpaces=True, reportingMode="silence")


def textgrid_from(tiers: Mapping[str, Sequence[Interval]], start: float, end: float) -> Textgrid:
    """A praatio `Textgrid` of interval tiers, from `start` to `end` seconds or as far as they reach.

    Raises praatio's TextgridStateError when intervals of a tier overlap or have no length.
    """
    from praatio.data_classes.interval_tier import IntervalTier
    from praatio.data_classes.textgrid import Textgrid

    start, end = float(start), float(end)  # praatio writes the repr of these numbers
    textgrid = Textgrid(start, end)
    for name, intervals in tiers.items():
        entries = [(interval.start, interval.end, interval.label) for interval in intervals]
        textgrid.addTier(IntervalTier(name, entries, start, end), reportingMode="silence")
    return textgrid


def tiers_of(textgrid: Textgrid) -> Recording:
    """The interval tiers of a praatio `Textgrid`, with their numbers in it; point tiers are ignored."""
    tiers = tuple(
        Tier(tier.name, tuple(Interval(label, start, end) for start, end, label in tier.entries), number)
        for number, tier in enumerate(textgrid.tiers, 1)
        if tier.tierType == "IntervalTier"
    )
    return Recording(tiers, textgrid.minTimestamp, textgrid.maxTimestamp)
