"""Small films of a face that a made-up tracker knows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
from faces import head_face

from phonanim.corpus.tracking import Tracker
from phonanim.media.video import write_film
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

FRAMES, ROWS, COLUMNS, RATE = 20, 96, 128, 25
PHONES = (("sil", 0.0, 0.2), ("M", 0.2, 0.4), ("AA", 0.4, 0.6), ("sil", 0.6, 0.8))
BLIND = 10  # a frame whose top left pixel is darker than this has no face for the tracker


def make_film(path: Path, dark: tuple[int, ...] = (), rate: int = RATE, sound: bool = True) -> Path:
    """A grey film; frames in `dark` are black."""
    frames = [np.full((ROWS, COLUMNS, 3), 0 if n in dark else 120, np.uint8) for n in range(FRAMES)]
    noise = np.random.default_rng(0).normal(0, 0.05, 16000 * FRAMES // rate).astype(np.float32)
    write_film(frames, path, Fraction(rate), noise if sound else None)
    return path


def put_alignment(film: Path, stretch: float = 1.0) -> None:
    """A TextGrid of M and AA beside a film."""
    phones = [Interval(label, start * stretch, end * stretch) for label, start, end in PHONES]
    words = [Interval("ma", 0.2 * stretch, 0.6 * stretch)]
    write_textgrid(film.with_suffix(".TextGrid"), {"words": words, "phones": phones}, 0.8 * stretch)


def head_shape(number: int) -> np.ndarray:
    """The shipped head's landmarks in a frame, (478, 3) pixels: it opens its mouth and moves a little."""
    face = head_face()
    opened = np.array([np.sin(number / 3), 0.2 * np.cos(number / 2), 0, 0, 0]) * face.std
    shape = face.instance(opened[None])[0] * [0.5, -0.5, -0.5]
    return shape + np.array([64 + 0.3 * np.sin(number), 30, 0])


def fake_tracker() -> Tracker:
    """A tracker that sees the head in every frame that is not black."""

    def follow(frames: Iterable[np.ndarray]) -> Iterator[np.ndarray | None]:
        for number, frame in enumerate(frames):
            yield head_shape(number) if frame[0, 0, 0] > BLIND else None

    return Tracker("made up", head_face().indices, follow, "no face was found")
