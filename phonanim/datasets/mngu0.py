"""mngu0: one speaker with six sensors, 1,354 sentences of newspaper, at 200 Hz."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from phonanim.datasets import Card, Recording, intervals, not_found
from phonanim.datasets._est import sensors
from phonanim.datasets._files import read_list, sound_loader

CARD = Card(
    title="mngu0, day 1",
    kind="sensors",
    content="1 speaker, 1,354 sentences, six sensors in 3D, 200 Hz, phones (forced)",
    licence="research, on request",
    ask="University of Edinburgh, Korin Richmond (homepages.inf.ed.ac.uk/korin/site/research/mngu0/)",
    layout="`mngu0_s1_ema_basic*/*.ema`, `mngu0_s1_wav_16kHz*/*.wav`, `mngu0_s1_lab*/*.lab`, and "
    "`trainfiles.txt`, `validationfiles.txt`, `testfiles.txt` of `mngu0_s1_ema_filesets*`",
    split="the file sets of the corpus: 1,137 train, 63 validation, 63 test",
    source="Richmond, Hoole and King 2011",
)
CENTIMETRES = 10.0  # mm
SENSORS = {
    name: tuple(f"{coil}_p{axis}" for axis in "xyz")
    for name, coil in (
        ("TT", "T1"), ("TB", "T2"), ("TD", "T3"), ("LI", "jaw"), ("UL", "upperlip"), ("LL", "lowerlip"),
    )
}  # fmt: skip
SPLITS = {"train": "trainfiles.txt", "validation": "validationfiles.txt", "test": "testfiles.txt"}


def recordings(folder: Path) -> Iterator[Recording]:
    """The recordings, sorted by name. Raises CorpusError for another layout."""
    paths = sorted(folder.glob("mngu0_s1_ema_basic*/**/*.ema"))
    if not paths:
        raise not_found(folder, "mngu0", "mngu0_s1_ema_basic*/*.ema")
    sounds = {path.stem: path for path in folder.glob("mngu0_s1_wav_16kHz*/**/*.wav")}
    labels = {path.stem: path for path in folder.glob("mngu0_s1_lab*/**/*.lab")}
    splits = _splits(folder)
    for path in paths:
        label = labels.get(path.stem)
        yield Recording(
            path.stem,
            "s1",
            splits.get(path.stem, ""),
            partial(sensors, path, SENSORS, CENTIMETRES),
            sound_loader(sounds.get(path.stem, folder / "none")),
            partial(intervals, label) if label else None,
        )


def _splits(folder: Path) -> dict[str, str]:
    return {
        name: split
        for split, file in SPLITS.items()
        for path in sorted(folder.glob(f"mngu0_s1_ema_filesets*/**/{file}"))
        for name in read_list(path)
    }
