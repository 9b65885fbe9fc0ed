"""HPRC: eight speakers, 720 sentences at two rates, sensors and sound in one MATLAB file per recording."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.core.mat import DAMAGE, read_signals
from phonanim.datasets import Card, Frames, Recording, not_found
from phonanim.errors import CorpusError
from phonanim.media.audio import Sound
from phonanim.speech.alignment import Interval

CARD = Card(
    title="Haskins Production Rate Comparison (HPRC)",
    kind="sensors",
    content="8 speakers, 720 Harvard sentences at two rates, seven sensors in 3D, 100 Hz, phones (forced)",
    licence="GPL 3.0",
    ask="Haskins Laboratories, Mark Tiede",
    layout="`**/<speaker>_B<block>_S<sentence>_R<repetition>_<N or F>.mat`: a structure array with NAME, "
    "SRATE, SIGNAL, and with SENTENCE and PHONES at the element AUDIO",
    split="none is published",
    source="Tiede et al. 2017",
    assumed="seconds as the unit of PHONES; the first three columns of SIGNAL are x, y, z in mm",
)
NAME = re.compile(r"([FM]\d\d)_B\d\d_S\d\d_R\d\d_[NF]")
AUDIO = "AUDIO"


def recordings(folder: Path) -> Iterator[Recording]:
    """The recordings, sorted by name. Raises CorpusError for another layout."""
    paths = [path for path in folder.glob("**/*.mat") if NAME.fullmatch(path.stem)]
    if not paths:
        raise not_found(folder, "HPRC", "files like F01_B01_S01_R01_N.mat, at any depth")
    for path in sorted(paths, key=lambda path: path.stem):
        frames, sound, phones = partial(_frames, path), partial(_sound, path), partial(_phones, path)
        yield Recording(path.stem, path.stem[:3], "", frames, sound, phones)


def _frames(path: Path) -> Frames:
    """The sensors, (frames, sensors, 3)."""
    tracks = {name: track for name, track in read_signals(path).items() if name != AUDIO}
    try:
        values = np.stack([np.asarray(track["SIGNAL"])[:, :3] for track in tracks.values()], axis=1)
        rate = float(next(iter(tracks.values()))["SRATE"])
    except DAMAGE as error:
        raise CorpusError(f"{path}: has no sensors with SRATE and SIGNAL ({error!r})") from error
    return Frames(values.astype(np.float32), rate, tuple(tracks), "mm")


def _sound(path: Path) -> Sound:
    """The recording; whole numbers are 16-bit samples."""
    track = _audio(path)
    samples = np.asarray(track["SIGNAL"])
    scale = 32768 if np.issubdtype(samples.dtype, np.integer) else 1
    return Sound((samples.ravel() / scale).astype(np.float32), round(float(track["SRATE"])))


def _phones(path: Path) -> tuple[Interval, ...]:
    found = _audio(path).get("PHONES", [])
    phones = [found] if isinstance(found, Mapping) else list(found)
    return tuple(Interval(str(p["LABEL"]), float(p["OFFS"][0]), float(p["OFFS"][1])) for p in phones)


def _audio(path: Path) -> Mapping[str, Any]:
    tracks = read_signals(path)
    if AUDIO not in tracks:
        raise CorpusError(f"{path}: has no element {AUDIO}; it has {', '.join(tracks)}")
    return tracks[AUDIO]
