"""UUDaMM: two actors in conversation, the controls of one character, at 30 frames per second."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np

from phonanim.datasets import Card, Frames, Recording, not_found
from phonanim.datasets._files import faceformer_recordings
from phonanim.datasets._pickles import Scaler, read_scaler
from phonanim.errors import CorpusError

CARD = Card(
    title="Utrecht University Dyadic Multimodal MoCap data set (UUDaMM)",
    kind="controls",
    content="2 speakers, 9 h 41 min, 192 controls of the character Ray; captured at 120 fps, used at 30",
    licence="not published; on request",
    ask="Utrecht University, Zerrin Yumak",
    layout="prepared pieces of 10 s: `vertices_npy/<speaker>_<number>.npy` (300 frames of 192 controls, "
    "scaled), `wav/` and `scaler_192.pkl`",
    split="of 2,537 pieces a speaker 2,029 train, 254 validation, 254 test",
    source="Nikolov et al. 2021; Stan 2023, section 4.2.1 and table 3",
    assumed="the layout (that of the published code of FaceDiffuser); the order in which pieces are drawn "
    "(Python's `random`, seed 1, as there); that `scaler_192.pkl`, of which scikit-learn's MinMaxScaler and "
    "StandardScaler are read, scaled the pieces: its inverse gives the character's own controls, and without "
    "the file they stay scaled",
)
FPS = 30.0
SCALER = "scaler_192.pkl"
PIECES, TRAIN, VALIDATION = 2537, 2029, 254


def recordings(folder: Path) -> Iterator[Recording]:
    """The pieces, sorted by name. Raises CorpusError for another layout."""
    if not any((folder / "vertices_npy").glob("*_*.npy")):
        raise not_found(folder, "UUDaMM", "vertices_npy/<speaker>_<number>.npy")
    pieces, scaler = faceformer_recordings(folder, FPS, split_of, 1), folder / SCALER
    if not scaler.is_file():
        return pieces
    unscale = read_scaler(scaler)
    return (replace(piece, frames=partial(unscaled, piece.frames, unscale)) for piece in pieces)


def unscaled(scaled: Callable[[], Frames], scaler: Scaler) -> Frames:
    """The controls of the character. Raises CorpusError for a scaler of another number of controls."""
    frames = scaled()
    if frames.values.shape[1:] != scaler.factor.shape:
        raise CorpusError(
            f"{SCALER}: is of {len(scaler.factor)} controls, and a piece has {frames.values.shape[1]}"
        )
    return replace(frames, values=(frames.values * scaler.factor + scaler.offset).astype(np.float32))


def split_of(speaker: str, number: str) -> str:
    """The split of a piece, the same for both speakers of a conversation."""
    place = _order().get(int(number)) if number.isdecimal() else None
    if place is None:
        return ""
    return "train" if place < TRAIN else "validation" if place < TRAIN + VALIDATION else "test"


@cache
def _order() -> dict[int, int]:
    numbers = list(range(1, PIECES + 1))
    random.Random(1).shuffle(numbers)
    return {number: place for place, number in enumerate(numbers)}
