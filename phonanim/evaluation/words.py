"""Words read from the lips of a take by a network of someone else's, which knows nothing of this package.

A reader is a TorchScript file for isolated words: grey pictures of a mouth, (1, 1, 29, 88, 88) at 25 frames
per second, standardized, and their number, (1,), in; scores of the words of a list, (1, words), out. Networks
trained on LRW (Chung and Zisserman 2016) have this form. Pictures are of the shipped head, which ARKit curves
move, cut as LRW's are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.decode import MAX_TEXT, read_utf8
from phonanim.errors import EvaluationError, MissingExtraError
from phonanim.face.model import MOUTH_CORNER_LEFT, MOUTH_CORNER_RIGHT
from phonanim.rig.head import load_head
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.rig.morphs import plain_name
from phonanim.rig.render import View, render
from phonanim.speech.alignment import Interval
from phonanim.speech.spoken_words import plain_word

Array = NDArray[np.float64]

FRAMES, FPS, SIZE = 29, 25.0, 88
SPAN = 0.102  # metres that a picture shows: 88 pixels of LRW's, in which pupils are 54 pixels apart
MEAN, DEVIATION = 0.421, 0.165  # of LRW's pictures, from 0 to 1
GREY = np.array([0.299, 0.587, 0.114])  # ITU-R BT.601
MOUTH = (MOUTH_CORNER_RIGHT, MOUTH_CORNER_LEFT, 0, 17)


@dataclass(frozen=True)
class WordReader:
    """`score` turns grey pictures (frames, SIZE, SIZE), 0 to 255, into log probabilities of `words`."""

    words: tuple[str, ...]
    score: Callable[[NDArray[np.uint8]], Array]


@dataclass(frozen=True)
class WordRead:
    """One word: `rank` is 1 where it is the first guess, `best` is that guess."""

    word: str
    rank: int
    log_p: float
    best: str


def load_word_reader(network: Path, words: Path) -> WordReader:
    """A TorchScript network and its words, one a line. Raises EvaluationError or MissingExtraError.

    A TorchScript file is a program: load only those that you trust.
    """
    try:
        import torch
    except ImportError as error:
        raise MissingExtraError("a reader of words needs torch: pip install 'phonanim[train]'") from error
    try:
        listed = tuple(
            line.strip().lower() for line in read_utf8(words, MAX_TEXT).splitlines() if line.strip()
        )
        load: Any = torch.jit.load
        module = load(str(network), map_location="cpu").eval()
    except (OSError, RuntimeError, ValueError) as error:
        raise EvaluationError(f"{network}, {words}: cannot be read as a reader of words ({error})") from error

    def score(pictures: NDArray[np.uint8]) -> Array:
        given = torch.tensor((pictures / 255 - MEAN) / DEVIATION, dtype=torch.float32)
        with torch.no_grad():
            found = module(given[None, None], torch.tensor([len(pictures)]))
        if tuple(found.shape) != (1, len(listed)):
            raise EvaluationError(
                f"{network}: scores {tuple(found.shape)}, and {words} has {len(listed)} words"
            )
        return np.asarray(torch.log_softmax(found[0].double(), 0).numpy())

    return WordReader(listed, score)


def read_words(take: Animation, reader: WordReader, words: Iterable[Interval] = ()) -> list[WordRead]:
    """What is read at each word of a take that the reader knows; `words` are the take's own by default.

    Raises EvaluationError when no curve moves the shipped head.
    """
    found = []
    for word in tuple(words) or take.words:
        said = plain_word(word.label)
        if said not in reader.words:
            continue
        scores = reader.score(draw_word(take, (word.start + word.end) / 2))
        place = reader.words.index(said)
        rank = 1 + int((scores > scores[place]).sum())
        found.append(WordRead(said, rank, float(scores[place]), reader.words[int(scores.argmax())]))
    return found


def draw_word(take: Animation, middle: float) -> NDArray[np.uint8]:
    """Grey pictures of the mouth around an instant in seconds, (FRAMES, SIZE, SIZE)."""
    head, spots = load_head(), shipped_landmarks().take(MOUTH)
    named = {plain_name(target): target for target in head.targets}
    channels = tuple(named.get(plain_name(name), name) for name in take.channels)
    if not set(channels) & set(head.targets):
        raise EvaluationError("no curve of the take moves the shipped head; make it with an ARKit rig")
    times = middle + (np.arange(FRAMES) - FRAMES // 2) / FPS
    values = np.stack([np.interp(times, take.times, curve) for curve in take.values.T], axis=1)
    weights = head.weights(values.astype(np.float32), channels)
    shapes = [head.vertices + np.tensordot(row, head.deltas, axes=1) for row in weights]
    centre = np.mean([spots.of(shape).mean(axis=0) for shape in shapes], axis=0)
    view = View((float(centre[0]), float(centre[1]), float(centre[2])), SPAN, SIZE, SIZE)
    return np.stack([np.round(render(shape, head, view) @ GREY).astype(np.uint8) for shape in shapes])
