"""IMFT'23: the speaker of IMT'22, with the controls of a MetaHuman fitted to sensors and video."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from phonanim.datasets import Card, Recording
from phonanim.datasets._lists import list_recordings

CARD = Card(
    title="IMFT'23",
    kind="controls",
    content="1 speaker, 1,700 sentences, 2.28 h, 67 controls of a MetaHuman, 50 fps",
    licence="as agreed with the author",
    ask="the author of Medina 2023",
    layout="`params/<name>.npy` (frames of 67 controls), `wav/<name>.wav`, maybe `train.lst`, `test.lst` and "
    "`phones/<name>.TextGrid`",
    split="80-20 train and test: `train.lst` and `test.lst`, or drawn with the seed 0",
    source="Medina 2023, sections 4.1.3 and 4.7",
    assumed="the names of the folders",
)
FPS = 50.0


def recordings(folder: Path) -> Iterator[Recording]:
    """The recordings, sorted by name. Raises CorpusError for another layout."""
    return list_recordings(folder, "IMFT'23", "params", FPS, 1)
