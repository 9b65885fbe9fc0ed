"""FACEGOOD: one Mandarin speaker, 116 controls of a rig that artists solved from film, with sound."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE, decode_rate, read_arrays
from phonanim.datasets import Card, Frames, Recording, not_found
from phonanim.datasets._files import sound_loader
from phonanim.errors import CorpusError

CARD = Card(
    title="FACEGOOD Audio2Face",
    kind="controls",
    content="1 speaker, 7 takes, 656 s, 116 controls of a rig, 30 fps, Mandarin, no transcript",
    licence="MIT",
    ask="github.com/FACEGOOD/FACEGOOD-Audio2Face",
    layout="`curves.npz` (`fps`, `names`, an array (frames, controls) for each take) and `<take>.flac` or "
    "`.wav`",
    split="all takes but the last two train, the last but one validation, the last test",
    source="FACEGOOD 2022",
    assumed="the layout (takes collected in one archive); the split, as none is published",
)
FACTS = ("fps", "names")


def recordings(folder: Path) -> Iterator[Recording]:
    """The takes, sorted by name. Raises CorpusError for another layout."""
    path = folder / "curves.npz"
    if not path.is_file():
        raise not_found(folder, CARD.title, "curves.npz and <take>.flac")
    takes = sorted(set(_arrays(path)) - set(FACTS))
    for place, take in enumerate(takes):
        split = {len(takes) - 2: "validation", len(takes) - 1: "test"}.get(place, "train")
        sound = sound_loader(folder / f"{take}.flac") or sound_loader(folder / f"{take}.wav")
        yield Recording(take, "facegood", split, partial(load, path, take), sound)


def load(path: Path, take: str) -> Frames:
    """The controls of a take. Raises CorpusError."""
    arrays = _arrays(path)
    try:
        values = arrays[take].astype(np.float32)
        names = tuple(str(name) for name in arrays["names"].tolist())
        fps = decode_rate(float(arrays["fps"]))
    except DAMAGE as error:
        raise CorpusError(f"{path}: has no controls of {take} ({error!r}); fetch it again") from error
    if values.ndim != 2 or values.shape[1] != len(names):
        raise CorpusError(f"{path}: {take} has frames of {values.shape[1:]} controls, but {len(names)} names")
    return Frames(values, fps, names)


@lru_cache(maxsize=1)
def _arrays(path: Path) -> dict[str, NDArray[Any]]:
    try:
        return read_arrays(path)
    except (OSError, *DAMAGE) as error:
        raise CorpusError(f"{path}: is not an archive of arrays ({error}); fetch it again") from error
