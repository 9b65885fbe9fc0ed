"""Papagayo projects (.pgo): voices, phrases, words, and mouth shapes at frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from phonanim.readers._rows import from_starts
from phonanim.readers._shapes import shape_phones
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "Papagayo project"


def recognizes(source: AlignmentFile) -> bool:
    """Whether the first line is that of a Papagayo project."""
    return source.text.lstrip().startswith("lipsync version 1")


def read(source: AlignmentFile) -> Recording:
    """For each voice, its words, and its shapes as phones."""
    rows = iter([line.strip() for line in source.text.splitlines()][2:])
    try:
        fps, frames, voices = float(next(rows)), int(next(rows)), int(next(rows))
        tiers = [tier for number in range(voices) for tier in _voice(rows, fps, 2 * number + 1)]
        end = frames / fps
    except (*DAMAGE, StopIteration) as error:
        raise source.error("is truncated or damaged; save it again") from error
    _, language, notes = shape_phones(shape for tier in tiers[::2] for shape in tier.intervals)
    tiers = [
        replace(tier, intervals=shape_phones(tier.intervals)[0]) if n % 2 == 0 else tier
        for n, tier in enumerate(tiers)
    ]
    return Recording(tuple(tiers), 0.0, end, notes, language, 1 / fps)


def _voice(rows: Iterator[str], fps: float, number: int) -> list[Tier]:
    """The phones and the words of one voice."""
    name, _text, phrases = next(rows), next(rows), int(next(rows))
    shapes: list[tuple[float, str]] = []
    words: list[Interval] = []
    for _ in range(phrases):
        next(rows), next(rows), next(rows)  # its text, its first and its last frame
        for _ in range(int(next(rows))):
            word, first, last, count = next(rows).rsplit(maxsplit=3)
            words.append(Interval(word, int(first) / fps, (int(last) + 1) / fps))
            for _ in range(int(count)):
                frame, shape = next(rows).split()
                shapes.append((int(frame) / fps, shape))
            shapes.append(((int(last) + 1) / fps, "rest"))
    last_time = shapes[-1][0] + 1 / fps if shapes else 0.0
    phones = [shape for shape in from_starts(shapes, last_time) if shape.end > shape.start] if shapes else []
    return [Tier("phones", tuple(phones), number, name), Tier("words", tuple(words), number + 1, name)]
