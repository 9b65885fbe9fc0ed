"""Errors by phone and by class of phones, and the frames that are speech."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.metrics.arrays import Array
from phonanim.speech.inventory import INVENTORY, LIPS
from phonanim.speech.phones import PhoneTrack

PHONE_CLASSES: dict[str, NDArray[np.bool_]] = {
    "vowels": INVENTORY.where(kind="vowel"),
    "consonants": INVENTORY.where(kind="consonant"),
    "bilabials": INVENTORY.where(place="bilabial") & INVENTORY.where(lips="closed"),
    "labiodentals": INVENTORY.where(place="labiodental"),
    **{f"lips {shape}": INVENTORY.where(lips=shape) for shape in LIPS},
}
"""Classes of phones by their visible articulation: a mask of the 41 codes for each."""


@dataclass(frozen=True)
class PhoneError:
    """An error over one phone or class: `mean` in its unit over `frames` frames of `segments` segments."""

    name: str
    mean: float
    frames: int
    segments: int


def speech_mask(track: PhoneTrack, times: Array) -> NDArray[np.bool_]:
    """A mask of the instants in speech, not silence, (times,) -> (times,)."""
    return np.asarray(~INVENTORY.where(kind="silence")[track.sample(times)])


def phone_middles(track: PhoneTrack, phones: tuple[str, ...]) -> Array:
    """Middle of every segment of some phones, -> (segments,) seconds."""
    chosen = np.isin(track.codes, INVENTORY.codes(phones))
    return np.asarray((track.bounds[:-1][chosen] + track.bounds[1:][chosen]) / 2)


def by_phone(error: Array, times: Array, track: PhoneTrack) -> list[PhoneError]:
    """A per-frame error by phone, (frames,) twice -> one row per phone that has frames, in code order."""
    classes = {name: np.arange(len(INVENTORY.phones)) == code for code, name in enumerate(INVENTORY.phones)}
    return by_class(error, times, track, classes)


def by_class(
    error: Array,
    times: Array,
    track: PhoneTrack,
    classes: Mapping[str, NDArray[np.bool_]] = PHONE_CLASSES,
) -> list[PhoneError]:
    """A per-frame error by class of phones, (frames,) twice -> one row per class that has frames.

    `classes` are (41,) over the codes of the inventory; a phone may belong to several.
    """
    segments = track.segment_at(times)
    codes = track.codes[segments]
    return list(_rows(error, segments, codes, classes.items()))


def merge_tables(tables: Iterable[Iterable[PhoneError]]) -> list[PhoneError]:
    """Merge the tables of several lines: means weighted by frames, rows in order of first appearance."""
    gathered: dict[str, list[PhoneError]] = {}
    for table in tables:
        for row in table:
            gathered.setdefault(row.name, []).append(row)
    return [_merged(name, rows) for name, rows in gathered.items()]


def _merged(name: str, rows: list[PhoneError]) -> PhoneError:
    frames = sum(row.frames for row in rows)
    total = sum(row.mean * row.frames for row in rows)
    return PhoneError(name, total / frames, frames, sum(row.segments for row in rows))


def _rows(
    error: Array,
    segments: NDArray[np.int64],
    codes: NDArray[np.uint8],
    classes: Iterable[tuple[str, NDArray[np.bool_]]],
) -> Iterable[PhoneError]:
    for name, members in classes:
        mine = members[codes]
        if mine.any():
            count = len(np.unique(segments[mine]))
            yield PhoneError(name, float(error[mine].mean()), int(mine.sum()), count)
