"""Alignments: labelled stretches of time, as an aligner or a phonetician wrote them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Interval:
    """One label from `start` to `end`, in seconds."""

    label: str
    start: float
    end: float


@dataclass(frozen=True, slots=True)
class Alignment:
    """The phone tier of one recording.

    `intervals` are in time order and do not overlap; gaps between them are silence.
    `duration` is the end of the file in seconds, `tier` the name of the tier that was read,
    `source` the path for error messages, `words` the word tier if the file has one.
    """

    intervals: tuple[Interval, ...]
    duration: float
    tier: str
    source: str
    words: tuple[Interval, ...] = ()
