"""MOCHA-TIMIT: British speakers with eight sensors in the midsagittal plane, 460 sentences, at 500 Hz."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from phonanim.datasets import Card, Recording, intervals, not_found
from phonanim.datasets._est import sensors
from phonanim.datasets._files import sound_loader

CARD = Card(
    title="MOCHA-TIMIT",
    kind="sensors",
    content="2 speakers (and some unfinished), 460 sentences, eight sensors in 2D, 500 Hz, phones (forced)",
    licence="non-commercial",
    ask="University of Edinburgh, CSTR (data.cstr.ed.ac.uk/mocha/)",
    layout="`<speaker>*/<speaker>_<NNN>.ema`, `.wav` (NIST SPHERE), `.lab`",
    split="sentences whose number ends in 2 test, in 6 validation, the others train",
    source="Wrench 1999; split of Richmond 2002",
    assumed="unit of the traces (0.01 mm); the split, from memory of the literature",
)
HUNDREDTHS = 0.01  # mm
SENSORS = {
    name: (f"{coil}_x", f"{coil}_y")
    for name, coil in (
        ("UI", "ui"), ("LI", "li"), ("UL", "ul"), ("LL", "ll"), ("TT", "tt"), ("TB", "tb"), ("TD", "td"),
        ("V", "v"),
    )
}  # fmt: skip
NAME = re.compile(r"([a-z]+\d)_(\d{3})")


def recordings(folder: Path) -> Iterator[Recording]:
    """The recordings, sorted by name. Raises CorpusError for another layout."""
    paths = [path for path in folder.glob("*/*.ema") if NAME.fullmatch(path.stem)]
    if not paths:
        raise not_found(folder, "MOCHA-TIMIT", "<speaker>/<speaker>_<NNN>.ema")
    for path in sorted(paths, key=lambda path: path.stem):
        label = path.with_suffix(".lab")
        yield Recording(
            path.stem,
            path.stem.partition("_")[0],
            {"2": "test", "6": "validation"}.get(path.stem[-1], "train"),
            partial(sensors, path, SENSORS, HUNDREDTHS),
            sound_loader(path.with_suffix(".wav")),
            partial(intervals, label) if label.is_file() else None,
        )
