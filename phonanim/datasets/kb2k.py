"""KB-2k: one speaker in front of a camera, and the parameters of an active appearance model."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from phonanim.datasets import Card, Recording
from phonanim.datasets._lists import list_recordings

CARD = Card(
    title="KB-2k",
    kind="controls",
    content="1 speaker, 2,543 sentences of TIMIT, 104 appearance parameters, 29.97 fps, phones by hand",
    licence="not published",
    ask="the authors of Taylor et al. 2012",
    layout="`aam/<name>.npy` (frames of 104 parameters), `wav/<name>.wav`, `phones/<name>.TextGrid` or "
    "`.lab`, maybe `train.lst` and `test.lst`",
    split="fifty sentences test, the others train: `train.lst` and `test.lst`, or drawn with the seed 0",
    source="Taylor et al. 2012; Taylor et al. 2017, section 4",
    assumed="the whole layout; which fifty sentences",
)
FPS = 30000 / 1001
HELD_OUT = 50 / 2543


def recordings(folder: Path) -> Iterator[Recording]:
    """The recordings, sorted by name. Raises CorpusError for another layout."""
    cuts = (("train", 1 - HELD_OUT), ("test", 1.0))
    return list_recordings(folder, "KB-2k", "aam", FPS, 1, cuts=cuts)
