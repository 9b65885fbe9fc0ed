"""Times of phones: gaps that are none, and clock times."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from phonanim.speech.alignment import Interval

_CLOCK = re.compile(r"(?:(\d{1,4}):)?(\d{1,2}):(\d{1,2})[.,](\d{1,9})")


def close_gaps(intervals: Iterable[Interval], longest: float) -> tuple[Interval, ...]:
    """The intervals, each lengthened to the start of the next where the gap is at most `longest` seconds."""
    closed: list[Interval] = []
    for interval in intervals:
        last = closed[-1] if closed else None
        if last is not None and last.start < interval.start and 0 < interval.start - last.end <= longest:
            closed[-1] = replace(last, end=interval.start)
        closed.append(interval)
    return tuple(closed)


def share(labels: Iterable[str], start: float, end: float) -> list[Interval]:
    """Labels that share the time from `start` to `end` equally."""
    shared = list(labels)
    step = (end - start) / max(len(shared), 1)
    return [Interval(label, start + n * step, start + (n + 1) * step) for n, label in enumerate(shared)]


def clock_seconds(text: str) -> float:
    """Seconds of a time such as 01:02:03,456 or 02:03.456. Raises ValueError for anything else."""
    found = _CLOCK.fullmatch(text.strip())
    if not found:
        raise ValueError(f"{text!r} is not a time such as 00:01:02.345")
    hours, minutes, whole, fraction = found.groups()
    return int(hours or 0) * 3600 + int(minutes) * 60 + int(whole) + float(f"0.{fraction}")
