"""Segments: stretches of one phone, between labels and a contiguous track."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from phonanim.speech.intervals import ROUNDING
from phonanim.speech.inventory import INVENTORY, SILENCE
from phonanim.speech.phones import PhoneTrack

SILENT = INVENTORY.code(SILENCE)


@dataclass(frozen=True, slots=True)
class Segment:
    """One phone code from `start` to `end`; for a closure, `releases` are the phones that may follow it."""

    code: int
    start: float
    end: float
    label: str
    releases: tuple[int, ...] = ()


def fill_gaps(segments: Iterable[Segment], duration: float) -> list[Segment]:
    """The segments with silence in the gaps, from 0 to the duration."""
    whole: list[Segment] = []
    time = 0.0
    for segment in segments:
        if segment.start > time:
            whole.append(Segment(SILENT, time, segment.start, ""))
        whole.append(segment)
        time = segment.end
    if duration - time > ROUNDING or not whole:
        whole.append(Segment(SILENT, time, duration, ""))
    elif time < duration:
        whole[-1] = replace(whole[-1], end=duration)
    return whole


def merge_segments(segments: Iterable[Segment]) -> list[Segment]:
    """Merge neighbouring silences and join closures to their releases."""
    fewer: list[Segment] = []
    for segment in segments:
        last = fewer[-1] if fewer else None
        silent = last is not None and last.code == segment.code == SILENT
        if last is not None and (silent or segment.code in last.releases):
            label = (last.label or segment.label) if silent else f"{last.label} {segment.label}"
            fewer[-1] = replace(segment, start=last.start, label=label)
        else:
            fewer.append(segment)
    return fewer


def to_track(segments: list[Segment]) -> PhoneTrack:
    """The segments as arrays."""
    return PhoneTrack(
        codes=np.array([segment.code for segment in segments], dtype=np.uint8),
        bounds=np.array([0.0, *(segment.end for segment in segments)]),
        labels=tuple(segment.label for segment in segments),
    )
