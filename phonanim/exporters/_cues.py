"""Mouth cues: one drawn shape at a time, from the phones by a published table."""

from __future__ import annotations

import csv
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from phonanim.alignment import Alignment, Interval
from phonanim.animation import Animation
from phonanim.errors import OutputError
from phonanim.inventory import INVENTORY, LEXICON, SILENCE
from phonanim.language import to_phones

SHORTEST = 0.04  # seconds: a drawing held for less than a frame of film is not seen
CLOSURES = ("m", "f")  # shapes of these phones are shown however short they are


def mouth_cues(animation: Animation, table: str, path: Path) -> list[Interval]:
    """Shapes end to end from time zero, labelled as the table `lexicon/visemes/<table>.csv` calls them.

    An animation of a rig with these very shapes is followed frame by frame, any other by its phones.
    Raises OutputError when it has neither, LabelError for a phone that its language does not know.
    """
    shapes = visemes(table)
    names = {name for pair in shapes.values() for name in pair}
    if set(animation.channels) <= names:
        cues = _from_curves(animation)
    elif animation.phones:
        cues = _from_phones(animation, shapes)
    else:
        raise OutputError(f"{path}: the animation has no phones, and mouth cues are made from them")
    return _settled(cues, {name for phone in CLOSURES for name in shapes[phone]}, shapes[SILENCE][0])


@cache
def visemes(table: str) -> dict[str, tuple[str, str]]:
    """The shape that each phone begins and ends with."""
    with (LEXICON / "visemes" / f"{table}.csv").open(newline="", encoding="utf-8") as file:
        return {row["phone"]: (row["viseme"], row["end"] or row["viseme"]) for row in csv.DictReader(file)}


def _from_curves(animation: Animation) -> list[Interval]:
    """The strongest shape of each frame, held for a frame."""
    strongest = np.asarray(animation.values).argmax(axis=1)
    times = animation.times
    return [
        Interval(animation.channels[shape], float(time), float(time) + 1 / animation.fps)
        for shape, time in zip(strongest, times, strict=True)
    ]


def _from_phones(animation: Animation, shapes: dict[str, tuple[str, str]]) -> list[Interval]:
    options = animation.provenance.get("options", {})
    last = max(float(animation.times[-1]), animation.phones[-1].end)
    alignment = Alignment(animation.phones, last, "phones", str(animation.provenance.get("input", "")))
    track, _ = to_phones(alignment, options.get("language", "auto"), options.get("unknown", "error"))
    cues = []
    for code, (start, end) in zip(track.codes, pairwise(track.bounds.tolist()), strict=True):
        first, second = shapes[INVENTORY.phones[code]]
        middle = (start + end) / 2
        cues += [Interval(first, start, middle), Interval(second, middle, end)]
    return cues


def _settled(cues: list[Interval], kept: set[str], rest: str) -> list[Interval]:
    """Equal neighbours joined; what is too short to be seen given to the shape before it."""
    joined: list[Interval] = [Interval(rest, 0.0, cues[0].start)] if cues[0].start > 0 else []
    for cue in _joined(cues):
        if joined and cue.end - cue.start < SHORTEST and cue.label not in kept:
            joined[-1] = Interval(joined[-1].label, joined[-1].start, cue.end)
        else:
            joined.append(cue)
    return _joined(joined)


def _joined(cues: list[Interval]) -> list[Interval]:
    joined: list[Interval] = []
    for cue in cues:
        if joined and joined[-1].label == cue.label:
            joined[-1] = Interval(cue.label, joined[-1].start, cue.end)
        else:
            joined.append(cue)
    return joined
