"""Write Praat TextGrids (long text format)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from phonanim.core.files import write_text
from phonanim.speech.alignment import Interval


def write_textgrid(path: Path, tiers: Mapping[str, Sequence[Interval]], duration: float) -> None:
    """Write interval tiers, gaps filled with empty labels, whole or not at all. Raises OutputError."""
    lines = [
        'File type = "ooTextFile"',
        'Object class = "TextGrid"',
        "",
        *_span(duration, ""),
        "tiers? <exists>",
        f"size = {len(tiers)}",
        "item []:",
    ]
    for number, (name, intervals) in enumerate(tiers.items(), start=1):
        lines += _tier(number, name, fill_gaps(intervals, duration), duration)
    write_text(path, "\n".join(lines) + "\n")


def fill_gaps(intervals: Sequence[Interval], duration: float) -> list[Interval]:
    """The same intervals with empty labels between them, from 0 to the duration in seconds."""
    filled, last = [], 0.0
    for interval in intervals:
        if interval.start > last:
            filled.append(Interval("", last, interval.start))
        filled.append(interval)
        last = interval.end
    if last < duration:
        filled.append(Interval("", last, duration))
    return filled


def _tier(number: int, name: str, intervals: Sequence[Interval], duration: float) -> list[str]:
    lines = [
        f"    item [{number}]:",
        '        class = "IntervalTier"',
        f"        name = {_quote(name)}",
        *_span(duration, " " * 8),
        f"        intervals: size = {len(intervals)}",
    ]
    for index, interval in enumerate(intervals, start=1):
        lines += [
            f"        intervals [{index}]:",
            f"            xmin = {_number(interval.start)}",
            f"            xmax = {_number(interval.end)}",
            f"            text = {_quote(interval.label)}",
        ]
    return lines


def _span(duration: float, indent: str) -> list[str]:
    return [f"{indent}xmin = 0", f"{indent}xmax = {_number(duration)}"]


def _number(seconds: float) -> str:
    """Seconds to the microsecond, without trailing noughts."""
    return f"{seconds:.6f}".rstrip("0").rstrip(".")


def _quote(text: str) -> str:
    """Praat doubles the quotation marks inside a string."""
    return '"' + text.replace('"', '""') + '"'
