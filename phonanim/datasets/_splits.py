"""Draw random splits, and cut recordings into pieces."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from phonanim.datasets import Frames, Recording
from phonanim.media.audio import Sound
from phonanim.speech.alignment import Interval

Cuts = Sequence[tuple[str, float]]  # a split, and the cumulative share at which it ends
EIGHTY_TEN_TEN: Cuts = (("train", 0.8), ("validation", 0.9), ("test", 1.0))
EIGHTY_TWENTY: Cuts = (("train", 0.8), ("test", 1.0))


def draw_splits(groups: Mapping[str, str], cuts: Cuts, rng: np.random.Generator) -> dict[str, str]:
    """The split of each name; every group is divided in the same proportions."""
    members: dict[str, list[str]] = defaultdict(list)
    for name, group in sorted(groups.items()):
        members[group].append(name)
    found = {}
    for _, names in sorted(members.items()):
        for place, index in enumerate(rng.permutation(len(names))):
            part = (place + 0.5) / len(names)
            found[names[index]] = next(split for split, end in cuts if part <= end)
    return found


def cut_pieces(recording: Recording, seconds: float, length: float) -> Iterator[Recording]:
    """Cut a recording into pieces of `length` seconds, numbered from 1; the remainder is dropped."""
    for number in range(int(seconds / length + 1e-6)):
        start = number * length
        yield replace(
            recording,
            name=f"{recording.name}_{number + 1:02d}",
            frames=partial(_frames, recording.frames, start, length),
            sound=partial(_sound, recording.sound, start, length) if recording.sound else None,
            phones=partial(_phones, recording.phones, start, length) if recording.phones else None,
        )


def _frames(whole: Callable[[], Frames], start: float, length: float) -> Frames:
    frames = whole()
    first, last = round(start * frames.fps), round((start + length) * frames.fps)
    return replace(frames, values=frames.values[first:last])


def _sound(whole: Callable[[], Sound], start: float, length: float) -> Sound:
    sound = whole()
    first, last = round(start * sound.rate), round((start + length) * sound.rate)
    return Sound(sound.samples[first:last], sound.rate)


def _phones(whole: Callable[[], tuple[Interval, ...]], start: float, length: float) -> tuple[Interval, ...]:
    cut = ((i.label, max(0.0, i.start - start), min(length, i.end - start)) for i in whole())
    return tuple(Interval(label, first, last) for label, first, last in cut if last > first)
