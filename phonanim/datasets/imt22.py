"""IMT'22: one speaker with ten sensors on tongue, lips and jaw."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from phonanim.datasets import Card, Recording
from phonanim.datasets._lists import list_recordings

CARD = Card(
    title="IMT'22",
    kind="sensors",
    content="1 speaker, 1,902 sentences, 2.55 h, ten sensors, 250 Hz, used at 50",
    licence="as agreed with the authors",
    ask="github.com/salmedina/SpeechDrivenTongueAnimation",
    layout="`ema/<name>.npy` (frames of ten sensors x 3), `wav/<name>.wav`, maybe `train.lst`, `test.lst` "
    "and `phones/<name>.TextGrid`",
    split="80-20 train and test: `train.lst` and `test.lst`, or drawn with the seed 0",
    source="Medina et al. 2022; Medina 2023, sections 2.1 and 3.2.2, table 2.1",
    assumed="the names of the folders, the order of the sensors (that of table 2.1), mm",
)
FPS = 50.0
SENSORS = ("TD", "TB", "BR", "BL", "TT", "UL", "LC", "LL", "LI", "LJ")


def recordings(folder: Path) -> Iterator[Recording]:
    """The recordings, sorted by name. Raises CorpusError for another layout."""
    return list_recordings(folder, "IMT'22", "ema", FPS, 3, SENSORS)
