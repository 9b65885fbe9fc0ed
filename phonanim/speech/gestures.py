"""Gestures: what the mouth does for each phone, and the segments with one gesture each.

A diphthong is two vowels, and an affricate is a stop and a fricative. So a model that has learned the parts
can animate a phone that is not in its training data. For the same reason, lips, jaw and tongue are
described by numbers (lexicon/gestures.csv) instead of names.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.core.lexicon import LEXICON
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack


@dataclass(frozen=True)
class Gestures:
    """The gestures by name, their articulation, and the parts of each phone.

    `articulation` (gestures, columns) holds numbers from 0 to 1 under `columns`. A part is one gesture of
    one phone, given by `part_gesture` (parts,) and `part_phone` (parts,). Phone p has the part
    `first_part[p]`; if `share[p]` < 1, the next part follows at that share of the phone's time.
    """

    names: tuple[str, ...]
    columns: tuple[str, ...]
    articulation: NDArray[np.float32]
    part_gesture: NDArray[np.int64]
    part_phone: NDArray[np.int64]
    first_part: NDArray[np.int64]
    share: NDArray[np.float64]


def load_gestures() -> Gestures:
    """Read lexicon/gestures.csv and lexicon/splits.csv."""
    with (LEXICON / "gestures.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = list(csv.reader(file))
    names = tuple(row[0] for row in rows)
    with (LEXICON / "splits.csv").open(encoding="utf-8", newline="") as file:
        splits = {row["phone"]: row for row in csv.DictReader(file)}
    gesture: list[int] = []
    phone: list[int] = []
    first: list[int] = []
    share: list[float] = []
    for code, name in enumerate(INVENTORY.phones):
        split = splits.get(name)
        parts = [split["first"], split["second"]] if split else ["sil" if name == "sp" else name]
        first.append(len(gesture))
        share.append(float(split["share"]) if split else 1.0)
        gesture += [names.index(part) for part in parts]
        phone += [code] * len(parts)
    return Gestures(
        names,
        tuple(header[1:]),
        np.array([row[1:] for row in rows], np.float32),
        np.array(gesture),
        np.array(phone),
        np.array(first),
        np.array(share),
    )


GESTURES = load_gestures()


@dataclass(frozen=True)
class PartTrack:
    """Contiguous gesture segments: segment i is part `parts[i]` from `bounds[i]` to `bounds[i + 1]` s."""

    parts: NDArray[np.int64]
    bounds: NDArray[np.float64]


def split_parts(track: PhoneTrack) -> PartTrack:
    """Phones -> gesture segments; diphthongs and affricates become two, all others stay one."""
    first, share = GESTURES.first_part[track.codes], GESTURES.share[track.codes]
    two = share < 1
    place = np.arange(len(first)) + np.concatenate([[0], np.cumsum(two)[:-1]])
    parts = np.empty(len(first) + int(two.sum()), np.int64)
    bounds = np.empty(len(parts) + 1)
    starts, lengths = track.bounds[:-1], np.diff(track.bounds)
    parts[place], bounds[place] = first, starts
    parts[place[two] + 1] = first[two] + 1
    bounds[place[two] + 1] = starts[two] + share[two] * lengths[two]
    bounds[-1] = track.bounds[-1]
    return PartTrack(parts, bounds)
