"""Multiface: 13 people, 50 sentences each, whole heads at 30 frames per second."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import read_utf8
from phonanim.core.files import read_bounded
from phonanim.datasets import Card, Frames, Recording, not_found
from phonanim.datasets._files import last_number, read_templates, sound_loader
from phonanim.errors import CorpusError

CARD = Card(
    title="Multiface",
    kind="vertices",
    content="13 speakers, 50 sentences, 7,306 vertices, 30 fps",
    licence="CC BY-NC 4.0",
    ask="github.com/facebookresearch/multiface (mesh and audio are enough)",
    layout="`<capture>/tracked_mesh/SEN_<sentence>/<frame>.bin` or `.obj`, and "
    "`<capture>/audio/SEN_<sentence>.wav`",
    split="nine speakers: sentences 1-40 train, 41-45 validation, 46-50 test; 46-50 of the other "
    "four: test_b",
    source="Wuu et al. 2022; split of Stan 2023, section 4.1.3",
    assumed="which nine speakers (here the first by name); sentences in alphabetical order without regard to "
    "case; there is a split only if all 50 are available; `.bin` has three 32-bit floats per vertex, "
    "little-endian, mm",
)

MAX_MESH = 1 << 28  # bytes of a frame: 7306 vertices have 90 kB
FPS = 30.0
SENTENCES, TRAINING = 50, 9


def recordings(folder: Path) -> Iterator[Recording]:
    """The recordings, sorted by name. Raises CorpusError for another layout."""
    sequences = sorted(path for path in folder.glob("*/tracked_mesh/SEN_*") if path.is_dir())
    if not sequences:
        raise not_found(folder, "Multiface", "<capture>/tracked_mesh/SEN_<sentence>/")
    speakers = sorted({path.parts[-3] for path in sequences})
    sentences = sorted({path.name for path in sequences}, key=str.upper)
    for path in sequences:
        speaker, sentence = path.parts[-3], path.name
        yield Recording(
            f"{speaker}_{sentence}",
            speaker,
            split_of(speakers.index(speaker), sentence, sentences),
            partial(load, path),
            sound_loader(path.parents[1] / "audio" / f"{sentence}.wav"),
            text=sentence.removeprefix("SEN_").replace("_", " "),
        )


def templates(folder: Path) -> dict[str, NDArray[np.float32]]:
    """Faces at rest by speaker, in the unit of the frames, of `templates.pkl`."""
    return read_templates(folder)


def split_of(speaker: int, sentence: str, sentences: Sequence[str]) -> str:
    """The split by the indices of the speaker and of the sentence among all."""
    if len(sentences) != SENTENCES:
        return ""
    place = sentences.index(sentence)
    if speaker >= TRAINING:
        return "test_b" if place >= 45 else ""
    return "train" if place < 40 else "validation" if place < 45 else "test"


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
