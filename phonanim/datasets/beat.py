"""BEAT: 30 people who talk and read, with the 51 weights that an iPhone tracks, at 60 frames per second."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from phonanim.core.decode import DAMAGE, read_json, read_utf8
from phonanim.core.lexicon import LEXICON
from phonanim.datasets import Card, Frames, Recording, intervals, not_found
from phonanim.datasets._files import faceformer_recordings, sound_loader
from phonanim.datasets._splits import EIGHTY_TEN_TEN, cut_pieces, draw_splits
from phonanim.errors import CorpusError
from phonanim.media.audio import audio_duration

CARD = Card(
    title="BEAT",
    kind="controls",
    content="30 speakers, 76 h, 51 ARKit weights, 60 fps, phones and words (MFA)",
    licence="non-commercial research (version 0.2.1)",
    ask="pantomatrix.github.io/BEAT",
    layout="`<speaker>/<speaker>_<name>_<type>_<first>_<last>.json`, `.wav`, `.TextGrid`; or prepared: "
    "`vertices_npy/<speaker>_<emotion>_<number>.npy` (300 frames of 51 weights) and `wav/`",
    split="English reading of four native speakers in pieces of 10 s, 80-10-10, speakers and emotions in "
    "equal parts",
    source="Liu et al. 2022; split of Stan 2023, section 4.2.2",
    assumed="that the weights of prepared pieces are in the order of the alphabet; which four speakers (here "
    "2, 4, 6, 8, as in the authors' own English configuration); which pieces (drawn here with the seed 42, "
    "from what is in the folder)",
)
SPEAKERS = ("2", "4", "6", "8")
PIECE = 10.0  # seconds
PREPARED_FPS = 30.0
SEED = 42
NAME = re.compile(r"(\d+)_([^_]+)_(\d+)_(\d+)_(\d+)")
NO_WEIGHTS = ("#", "TongueOut", "Head", "LeftEye", "RightEye")  # of the columns of Live Link Face
READ = "0"  # the type of English reading; 1 is conversation, higher numbers are other languages
EMOTIONS = {64: "neutral", 72: "happiness", 80: "anger", 86: "sadness", 94: "contempt", 102: "surprise",
            110: "fear", 118: "disgust"}  # fmt: skip
"""The last text of each emotion."""


def recordings(folder: Path) -> Iterator[Recording]:
    """Pieces of 10 s, sorted by name. Raises CorpusError for another layout."""
    if any((folder / "vertices_npy").glob("*_*_*.npy")):
        yield from _prepared(folder)
        return
    paths = [path for path in sorted(folder.glob("*/*.json")) if NAME.fullmatch(path.stem)]
    if not paths:
        raise not_found(folder, "BEAT", "<speaker>/<speaker>_<name>_<type>_<first>_<last>.json")
    found = {piece.name: (piece, group_of(path.stem)) for path in paths for piece in _pieces(path)}
    groups = {name: group for name, (_, group) in found.items() if group}
    splits = draw_splits(groups, EIGHTY_TEN_TEN, np.random.default_rng(SEED))
    for name, (piece, _) in sorted(found.items()):
        emotion = groups.get(name, "").partition(" ")[2]
        yield replace(piece, split=splits.get(name, ""), emotion=emotion)


def _prepared(folder: Path) -> Iterator[Recording]:
    """Pieces as the released code of FaceDiffuser cuts them, at 30 fps; the emotion is a number from 0."""
    pieces, emotions = [], tuple(EMOTIONS.values())
    for piece in faceformer_recordings(
        folder, PREPARED_FPS, lambda speaker, sentence: "", 1, names=weight_names()
    ):
        speaker, _, emotion = piece.speaker.rpartition("_")
        known = emotions[int(emotion)] if emotion.isdecimal() and int(emotion) < len(emotions) else ""
        pieces.append(replace(piece, speaker=speaker, emotion=known))
    groups = {one.name: f"{one.speaker} {one.emotion}" for one in pieces if one.speaker in SPEAKERS}
    splits = draw_splits(groups, EIGHTY_TEN_TEN, np.random.default_rng(SEED))
    for piece in pieces:
        yield replace(piece, split=splits.get(piece.name, ""))


def weight_names() -> tuple[str, ...]:
    """The 51 weights in the order of the data set: ARKit's without the tongue, by alphabet."""
    lines = read_utf8(LEXICON / "formats" / "livelink.txt").splitlines()
    named = (line for line in lines if line and not line.startswith(NO_WEIGHTS))
    return tuple(sorted(name[0].lower() + name[1:] for name in named))


def group_of(stem: str) -> str:
    """Speaker and emotion of a recording in the split; empty for others."""
    match = NAME.fullmatch(stem)
    if match is None or match[1] not in SPEAKERS or match[3] != READ:
        return ""
    emotion = next((name for last, name in EMOTIONS.items() if int(match[4]) <= last), "")
    return f"{match[1]} {emotion}" if emotion else ""


def _pieces(path: Path) -> Iterator[Recording]:
    audio = path.with_suffix(".wav")
    if not audio.is_file():
        raise CorpusError(f"{audio}: is missing; fetch the audio of BEAT too")
    speaker = path.stem.split("_")[1]
    grid = path.with_suffix(".TextGrid")
    phones = partial(intervals, grid) if grid.is_file() else None
    whole = Recording(path.stem, speaker, "", partial(load, path), sound_loader(audio), phones)
    yield from cut_pieces(whole, audio_duration(audio), PIECE)


@lru_cache(maxsize=2)
def load(path: Path) -> Frames:
    """The weights of a file, (frames, 51). Raises CorpusError."""
    try:
        document = read_json(path)
        values = np.array([frame["weights"] for frame in document["frames"]], np.float32)
        times = [frame["time"] for frame in document["frames"]]
        names = tuple(document["names"])
        fps = round((len(times) - 1) / (times[-1] - times[0]), 2)
    except (OSError, *DAMAGE) as error:
        raise CorpusError(f"{path}: has no facial weights ({error!r}); fetch it again") from error
    if values.shape[1:] != (len(names),):
        raise CorpusError(f"{path}: has frames of {values.shape[1:]} weights, but {len(names)} names")
    return Frames(values, fps, names)
