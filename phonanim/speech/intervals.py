"""Labelled intervals of time, and the tiers and recordings that contain them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from phonanim.core.decode import decode_number, decode_text
from phonanim.speech.alignment_file import quote_label

ROUNDING = 1e-3
"""Seconds. Aligners write milliseconds at best, so smaller gaps and overlaps are rounding errors."""


@dataclass(frozen=True, slots=True)
class Interval:
    """One label from `start` to `end`, in seconds."""

    label: str
    start: float
    end: float


@dataclass(frozen=True, slots=True)
class Tier:
    """One row of intervals; `number` counts from 1, as in the program that wrote the file.

    `speaker` is the speaker if the format gives it separately from the name.
    """

    name: str
    intervals: tuple[Interval, ...]
    number: int = 1
    speaker: str = ""

    def __str__(self) -> str:
        return f'{self.number} "{quote_label(self.name)}"'


@dataclass(frozen=True, slots=True)
class Recording:
    """The content of an alignment file: its interval tiers, and its first and last instant in seconds.

    `notes` report the assumptions of the reader; `language` is that of the labels if the format fixes it.
    `unit` is the time, in seconds, that the reader took a number of the file for. A word without a time has
    NaN in its tier; `spoken` is the language of the words as the file names it, if it does. `likely` is the
    unit that the times are probably in, where the file does not tell ("" where it does).
    """

    tiers: tuple[Tier, ...]
    start: float
    end: float
    notes: tuple[str, ...] = ()
    language: str = ""
    unit: float = 1.0
    spoken: str = ""
    likely: str = ""


def pack_intervals(intervals: tuple[Interval, ...]) -> list[list[Any]]:
    """Intervals as lists [label, start, end], for JSON."""
    return [[interval.label, interval.start, interval.end] for interval in intervals]


def unpack_intervals(items: list[list[Any]]) -> tuple[Interval, ...]:
    """The inverse of `pack_intervals`. Raises TypeError or ValueError where an item is not one."""
    return tuple(
        Interval(
            decode_text(label, "a label"),
            decode_number(start, "the start of a label"),
            decode_number(end, "the end of a label"),
        )
        for label, start, end in items
    )
