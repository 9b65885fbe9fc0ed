"""Mouth cues: one mouth shape at a time, from the phones by a published table."""

from __future__ import annotations

import csv
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.core.lexicon import LEXICON
from phonanim.errors import OutputError
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.inventory import INVENTORY, SILENCE
from phonanim.speech.language import to_phones

SHORTEST = 0.04  # seconds: a drawing that is shorter than a film frame is invisible
ROUNDING = 1e-9  # seconds
CLOSURES = ("m", "f")  # shapes of these phones are shown even if they are shorter


def mouth_cues(animation: Animation, table: str, path: Path) -> list[Interval]:
    """Contiguous shapes from time zero, with the names of the table `lexicon/visemes/<table>.csv`.

    An animation of a rig with these shapes is used frame by frame, any other by its phones. Raises
    OutputError when it has neither, LabelError for a phone that is unknown in its language.
    """
    shapes = phone_visemes(table)
    names = {name for pair in shapes.values() for name in pair}
    if set(animation.channels) <= names:
        cues = _from_curves(animation)
    elif animation.phones:
        cues = _from_phones(animation, shapes)
    else:
        raise OutputError(f"{path}: the animation has no phones, which are needed for mouth cues")
    return _settled(cues, {name for phone in CLOSURES for name in shapes[phone]}, shapes[SILENCE][0])


@cache
def phone_visemes(table: str) -> dict[str, tuple[str, str]]:
    """The shapes at the start and at the end of each phone."""
    with (LEXICON / "visemes" / f"{table}.csv").open(newline="", encoding="utf-8") as file:
        return {row["phone"]: (row["viseme"], row["end"] or row["viseme"]) for row in csv.DictReader(file)}


def _from_curves(animation: Animation) -> list[Interval]:
    """The strongest shape of each frame, for one frame."""
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
    language = animation.provenance.get("language", {}).get("name") or options.get("language", "auto")
    track, _ = to_phones(alignment, language, options.get("unknown", "error"))
    cues = []
    for code, (start, end) in zip(track.codes, pairwise(track.bounds.tolist()), strict=True):
        first, second = shapes[INVENTORY.phones[code]]
        middle = (start + end) / 2
        cues += [Interval(first, start, middle), Interval(second, middle, end)]
    return cues


def _settled(cues: list[Interval], kept: set[str], rest: str) -> list[Interval]:
    """Merge equal neighbours, and give the time of cues that are too short to the longer neighbour.

    The shortest is removed first. A closure is not removed, and takes time only if no other cue can.
    """
    before = [Interval(rest, 0.0, cues[0].start)] if cues[0].start > 0 else []
    held = _joined([*before, *cues])
    while short := [i for i, cue in enumerate(held) if _length(cue) < SHORTEST and cue.label not in kept]:
        brief = min(short, key=lambda i: _length(held[i]))
        near = [i for i in (brief - 1, brief + 1) if 0 <= i < len(held)]
        if not near:
            break
        heir = max(near, key=lambda i: (held[i].label not in kept, _length(held[i])))
        first, last = sorted((brief, heir))
        around = slice(max(first - 1, 0), last + 2)
        whole = Interval(held[heir].label, held[first].start, held[last].end)
        held[around] = _joined([*held[around.start : first], whole, *held[last + 1 : around.stop]])
    return held


def _length(cue: Interval) -> float:
    return cue.end - cue.start + ROUNDING


def _joined(cues: list[Interval]) -> list[Interval]:
    joined: list[Interval] = []
    for cue in cues:
        if joined and joined[-1].label == cue.label:
            joined[-1] = Interval(cue.label, joined[-1].start, cue.end)
        else:
            joined.append(cue)
    return joined
