"""VOCASET: 12 people, 40 sentences each, meshes in the topology of FLAME at 60 frames per second."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import map_array
from phonanim.datasets import Card, Frames, Recording, not_found
from phonanim.datasets._files import faceformer_recordings, read_templates
from phonanim.datasets._pickles import read_pickle
from phonanim.errors import CorpusError
from phonanim.media.audio import Sound

CARD = Card(
    title="VOCASET",
    kind="vertices",
    content="12 speakers, 40 sentences, 5,023 vertices (FLAME), 60 fps, 29 min",
    licence="non-commercial research, registration",
    ask="Max Planck Institute for Intelligent Systems (voca.is.tue.mpg.de)",
    layout="`data_verts.npy`, `raw_audio_fixed.pkl`, `subj_seq_to_idx.pkl`; "
    "or prepared: `vertices_npy/<speaker>_sentence<NN>.npy` and `wav/`; and `templates.pkl`",
    split="eight speakers train, all 40 sentences; two validation and two test, sentences 21-40",
    source="Cudeiro et al. 2019; split as in Fan et al. 2022 (FaceFormer), Stan 2023, section 4.1.2",
    assumed="metres in `data_verts.npy`; the prepared files keep the unit that they have",
)
FPS = 60.0
METRES = 1000.0  # mm
VALIDATION = ("FaceTalk_170811_03275_TA", "FaceTalk_170908_03277_TA")
TEST = ("FaceTalk_170809_00138_TA", "FaceTalk_170731_00024_TA")


def recordings(folder: Path) -> Iterator[Recording]:
    """The recordings, sorted by name. Raises CorpusError for another layout."""
    vertices, index = folder / "data_verts.npy", folder / "subj_seq_to_idx.pkl"
    if vertices.is_file() and index.is_file():
        return _raw(folder, vertices, read_index(index))
    if (folder / "vertices_npy").is_dir():
        return faceformer_recordings(folder, FPS, split_of, 3, "as distributed")
    raise not_found(folder, "VOCASET", "data_verts.npy and subj_seq_to_idx.pkl", "vertices_npy/*.npy")


def templates(folder: Path) -> dict[str, NDArray[np.float32]]:
    """Faces at rest by speaker, in the unit of the frames, of `templates.pkl`."""
    raw = (folder / "data_verts.npy").is_file()
    return read_templates(folder, METRES if raw else 1.0)


def split_of(speaker: str, sentence: str) -> str:
    """The split by speaker and sentence, such as "sentence21"."""
    if speaker not in (*VALIDATION, *TEST):
        return "train"
    if not sentence[-2:].isdecimal() or int(sentence[-2:]) <= 20:
        return ""
    return "validation" if speaker in VALIDATION else "test"


def read_index(path: Path) -> dict[tuple[str, str], tuple[int, ...]]:
    """The rows of each recording, by speaker and sentence. Raises CorpusError."""
    document = read_pickle(path)
    try:
        return {
            (str(speaker), str(sentence)): tuple(int(rows[frame]) for frame in sorted(rows))
            for speaker, sentences in sorted(document.items())
            for sentence, rows in sorted(sentences.items())
        }
    except (AttributeError, TypeError, ValueError) as error:
        raise CorpusError(f"{path}: is not an index of rows by speaker and sentence ({error})") from error


def _raw(
    folder: Path, vertices: Path, index: Mapping[tuple[str, str], tuple[int, ...]]
) -> Iterator[Recording]:
    audio = folder / "raw_audio_fixed.pkl"
    for (speaker, sentence), rows in index.items():
        yield Recording(
            f"{speaker}_{sentence}",
            speaker,
            split_of(speaker, sentence),
            partial(_frames, vertices, rows),
            partial(_sound, audio, speaker, sentence) if audio.is_file() else None,
        )


def _frames(path: Path, rows: tuple[int, ...]) -> Frames:
    """Some rows of the one large array; only these rows are read."""
    try:
        values = map_array(path)[list(rows)]
    except (OSError, ValueError, IndexError) as error:
        raise CorpusError(
            f"{path}: does not have the frames of the index ({error}); fetch it again"
        ) from error
    return Frames(values.astype(np.float32) * METRES, FPS, unit="mm")


@lru_cache(maxsize=1)
def _sounds(path: Path) -> Any:
    return read_pickle(path)


def _sound(path: Path, speaker: str, sentence: str) -> Sound:
    """A recording of 16-bit samples from the file that has them all."""
    try:
        found = _sounds(path)[speaker][sentence]
        samples, rate = (np.asarray(found["audio"]) / 32768).astype(np.float32), int(found["sample_rate"])
    except (KeyError, TypeError) as error:
        raise CorpusError(f"{path}: has no recording of {speaker} {sentence} ({error!r})") from error
    return Sound(samples, rate)
