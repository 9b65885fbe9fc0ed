"""Multiface: 13 people, 50 sentences each, whole heads at 30 frames per second."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import read_utf8
from phonanim.core.files import read_bounded
from phonanim.datasets import Card, Frames, Recording, not_found
from phonanim.datasets._files import faceformer_recordings, last_number, read_templates, sound_loader
from phonanim.errors import CorpusError

CARD = Card(
    title="Multiface",
    kind="vertices",
    content="13 speakers, 50 sentences, 7,306 vertices, 30 fps",
    licence="CC BY-NC 4.0",
    ask="github.com/facebookresearch/multiface (mesh and audio are enough)",
    layout="`<capture>/tracked_mesh/SEN_<sentence>/<frame>.bin` or `.obj`, and "
    "`<capture>/audio/SEN_<sentence>.wav`; or prepared: `vertices_npy/<speaker>_<sentence>.npy` (numbers; "
    "6,172 vertices, scaled to -1 and 1), `wav/` and `templates.pkl`",
    split="speakers 2 3 6 7 9 10 11 12 13: sentences 1-40 train, 41-45 validation, 46-50 test; 46-50 of the "
    "other four: test_b",
    source="Wuu et al. 2022; split of Stan 2023, section 4.1.3",
    assumed="speakers are numbered by name, which needs all 13, and sentences in alphabetical order without "
    "regard to case, which needs all 50: else there is no split; `.bin` has three 32-bit floats per vertex, "
    "little-endian, mm; prepared frames are scaled by the ranges of the released code of FaceDiffuser",
)

MAX_MESH = 1 << 28  # bytes of a frame: 7306 vertices have 90 kB
FPS = 30.0
SENTENCES, SPEAKERS = 50, 13
TRAINING = (2, 3, 6, 7, 9, 10, 11, 12, 13)
LOW = np.array([-117.798, -213.735, -177.091], np.float32)  # mm, of which a prepared frame has -1
HIGH = np.array([125.922, 185.79601, 75.365097], np.float32)  # and +1


def recordings(folder: Path) -> Iterator[Recording]:
    """The recordings, sorted by name. Raises CorpusError for another layout."""
    if (folder / "vertices_npy").is_dir():
        for one in faceformer_recordings(folder, FPS, prepared_split, 3):
            yield replace(one, frames=partial(in_mm, one.frames))
        return
    sequences = sorted(path for path in folder.glob("*/tracked_mesh/SEN_*") if path.is_dir())
    if not sequences:
        looked_for = "<capture>/tracked_mesh/SEN_<sentence>/", "vertices_npy/*.npy"
        raise not_found(folder, "Multiface", *looked_for)
    speakers = sorted({path.parts[-3] for path in sequences})
    sentences = sorted({path.name for path in sequences}, key=str.upper)
    for path in sequences:
        speaker, sentence = path.parts[-3], path.name
        yield Recording(
            f"{speaker}_{sentence}",
            speaker,
            split_of(speakers.index(speaker) + 1 if len(speakers) == SPEAKERS else 0, sentence, sentences),
            partial(load, path),
            sound_loader(path.parents[1] / "audio" / f"{sentence}.wav"),
            text=sentence.removeprefix("SEN_").replace("_", " "),
        )


def templates(folder: Path) -> dict[str, NDArray[np.float32]]:
    """Faces at rest by speaker, mm, of `templates.pkl`, which are scaled as prepared frames are."""
    prepared = (folder / "vertices_npy").is_dir()
    return {name: unscaled(rest) if prepared else rest for name, rest in read_templates(folder).items()}


def split_of(speaker: int, sentence: str, sentences: Sequence[str]) -> str:
    """The split by the number of the speaker, from 1, and the place of the sentence among all 50."""
    if len(sentences) != SENTENCES:
        return ""
    return split_by_numbers(speaker, sentences.index(sentence) + 1)


def split_by_numbers(speaker: int, sentence: int) -> str:
    """The split by the numbers of speaker and sentence, from 1."""
    if not (1 <= speaker <= SPEAKERS and 1 <= sentence <= SENTENCES):
        return ""
    if speaker not in TRAINING:
        return "test_b" if sentence > 45 else ""
    return "train" if sentence <= 40 else "validation" if sentence <= 45 else "test"


def prepared_split(speaker: str, sentence: str) -> str:
    """The split of prepared files, whose names are numbers, such as "02" and "41"."""
    numbered = speaker.isdecimal() and sentence.isdigit()
    return split_by_numbers(int(speaker), int(sentence)) if numbered else ""


def in_mm(scaled: Callable[[], Frames]) -> Frames:
    """Prepared frames in mm."""
    frames = scaled()
    return replace(frames, values=unscaled(frames.values), unit="mm")


def unscaled(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Coordinates between LOW and HIGH, (..., 3) mm, of those between -1 and 1."""
    return np.asarray((values + 1) / 2 * (HIGH - LOW) + LOW, np.float32)


def load(sequence: Path) -> Frames:
    """The frames of a folder, mm, without the motion of the head. Raises CorpusError."""
    paths = sorted(sequence.glob("*.bin"), key=last_number) or sorted(sequence.glob("*.obj"), key=last_number)
    frames = [read_mesh(path) for path in paths]
    if len({len(frame) for frame in frames}) != 1:
        raise CorpusError(f"{sequence}: has no frames, or frames of different sizes; fetch it again")
    return Frames(np.stack(frames), FPS, unit="mm")


def read_mesh(path: Path) -> NDArray[np.float32]:
    """Vertices (vertices, 3) of a file of floats, or of the lines of an OBJ. Raises CorpusError."""
    try:
        if path.suffix == ".bin":
            return np.frombuffer(read_bounded(path, MAX_MESH), "<f4").reshape(-1, 3)
        rows = [line.split()[1:4] for line in read_utf8(path, MAX_MESH).splitlines() if line.startswith("v ")]
        return np.array(rows, np.float32).reshape(-1, 3)
    except ValueError as error:
        raise CorpusError(f"{path}: has no vertices ({error}); fetch it again") from error
