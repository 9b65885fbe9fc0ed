"""BIWI: 14 people, 40 sentences in neutral and emotional speech, dense meshes at 25 frames per second."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import read_bounded
from phonanim.datasets import Card, Frames, Recording, not_found
from phonanim.datasets._files import (
    faceformer_recordings,
    last_number,
    read_obj,
    read_templates,
    sound_loader,
)
from phonanim.errors import CorpusError

CARD = Card(
    title="BIWI 3D Audiovisual Corpus of Affective Communication, B3D(AC)²",
    kind="vertices",
    content="14 speakers, 40 sentences neutral and emotional, 23,370 vertices, 25 fps",
    licence="research only, signed agreement",
    ask="ETH Zurich, Computer Vision Laboratory (data.vision.ee.ethz.ch/cvl/datasets/b3dac2.en.html)",
    layout="`faces/<speaker>/<sentence>/*.vl`, `audio/<speaker>_<sentence>_cut.wav` and "
    "`rigid_scans/<speaker>.obj`; or prepared: `vertices_npy/<speaker>_<sentence>.npy`, `wav/` and "
    "`templates.pkl`",
    split="emotional sentences of F2 F3 F4 M3 M4 M5: 1-32 train, 33-36 validation, 37-40 test; "
    "37-40 of the other eight: test_b",
    source="Fanelli et al. 2010; split of Fan et al. 2022 (FaceFormer), Stan 2023, section 4.1.1",
    assumed="unit of length; prepared numbers above 40 are the emotional sentences, or all are where none is "
    "above 40 and none begins with e; prepared frames and templates are scaled alike, and with "
    "`templates_orig.pkl` both are brought back to the scale of these",
)

MAX_BYTES = 1 << 28  # of a frame: 23,370 vertices have 280 kB
FPS = 25.0
UNIT = "as distributed"
TRAINING = ("F2", "F3", "F4", "M3", "M4", "M5")
SENTENCES = 40
EMOTIONAL = "emotional"
ORIGINAL = "templates_orig.pkl"


def recordings(folder: Path) -> Iterator[Recording]:
    """The recordings, sorted by name. Raises CorpusError for another layout."""
    if (folder / "vertices_npy").is_dir():
        yield from _prepared(folder)
        return
    sequences = sorted(path for path in folder.glob("faces/*/*") if any(path.glob("*.vl")))
    if not sequences:
        raise not_found(folder, "BIWI", "faces/<speaker>/<sentence>/*.vl", "vertices_npy/*.npy")
    for path in sequences:
        speaker, sentence = path.parent.name, path.name
        audio = folder / "audio" / f"{speaker}_{sentence}_cut.wav"
        yield Recording(
            f"{speaker}_{sentence}",
            speaker,
            split_of(speaker, sentence),
            partial(load, path),
            sound_loader(audio),
            emotion=emotion_of(sentence),
        )


def _prepared(folder: Path) -> Iterator[Recording]:
    """Recordings of `vertices_npy`, in their own scale where the templates in it are at hand."""
    names = [path.stem.rpartition("_")[2] for path in (folder / "vertices_npy").glob("*.npy")]
    alone = not any(emotion_of(name) == EMOTIONAL for name in names)  # the emotional sentences, from 1
    originals = read_templates(folder, name=ORIGINAL)

    def split(speaker: str, sentence: str) -> str:
        return split_of(speaker, f"e{sentence}" if alone else sentence)

    for one in faceformer_recordings(folder, FPS, split, 3, UNIT):
        emotion = EMOTIONAL if alone else emotion_of(one.name.rpartition("_")[2])
        rest = originals.get(one.speaker)
        frames = one.frames if rest is None else partial(_in_scale_of, one.frames, rest)
        yield replace(one, emotion=emotion, frames=frames)


def _in_scale_of(scaled: Callable[[], Frames], rest: NDArray[np.float32]) -> Frames:
    """Frames whose axes were divided by the reach of a face, and centred on its mean, in its own scale."""
    frames = scaled()
    if frames.values.shape[1:] != rest.shape:
        raise CorpusError(f"{ORIGINAL}: has faces of {rest.shape}, and frames are {frames.values.shape[1:]}")
    values = frames.values * np.ptp(rest, axis=0) + rest.mean(axis=0)
    return replace(frames, values=values.astype(np.float32))


def emotion_of(sentence: str) -> str:
    """Whether a sentence was said with emotion: "e05", or its number plus 40."""
    number = int("".join(filter(str.isdigit, sentence)) or 0)
    return EMOTIONAL if sentence.startswith("e") or number > SENTENCES else "neutral"


def templates(folder: Path) -> dict[str, NDArray[np.float32]]:
    """Faces at rest by speaker, in the scale of the frames: `rigid_scans`, or a pickle of prepared files."""
    scans = sorted((folder / "rigid_scans").glob("*.obj"))
    if scans and not (folder / "vertices_npy").is_dir():
        return {path.stem: read_obj(path) for path in scans}
    return read_templates(folder, name=ORIGINAL) or read_templates(folder)


def split_of(speaker: str, sentence: str) -> str:
    """The split by speaker and sentence: "e05", or its number plus 40, is the emotional sentence 5."""
    number = int("".join(filter(str.isdigit, sentence)) or 0)
    if not sentence.startswith("e") and number <= SENTENCES:
        return ""
    number = (number - 1) % SENTENCES + 1
    if speaker not in TRAINING:
        return "test_b" if number > 36 else ""
    return "train" if number <= 32 else "validation" if number <= 36 else "test"


def load(sequence: Path) -> Frames:
    """The frames of a folder of `.vl` files. Raises CorpusError when they differ in size."""
    frames = [read_vl(path) for path in sorted(sequence.glob("*.vl"), key=last_number)]
    if len({len(frame) for frame in frames}) > 1:
        raise CorpusError(f"{sequence}: its frames have different numbers of vertices; fetch it again")
    return Frames(np.stack(frames), FPS, unit=UNIT)


def read_vl(path: Path) -> NDArray[np.float32]:
    """Vertices (vertices, 3): a 32-bit count, then three 32-bit floats each. Raises CorpusError."""
    try:
        data = read_bounded(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        raise CorpusError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from error
    count = int.from_bytes(data[:4], "little")
    if count == 0 or len(data) != 4 + 12 * count:
        raise CorpusError(f"{path}: has {len(data)} bytes, which is not a count and as many vertices")
    return np.frombuffer(data, "<f4", offset=4).reshape(count, 3)
