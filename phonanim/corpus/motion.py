"""A corpus of other motion than landmarks: controls of a rig, sensors, or vertices, for phonanim.targets.

Frames stay on disk, one array for each clip, and are read when they are needed: data sets have gigabytes.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import (
    DAMAGE,
    DecodeError,
    decode_list,
    decode_part,
    decode_path_below,
    decode_rate,
    decode_table,
    decode_text,
    decode_whole,
    map_array,
    read_json,
    read_tensors,
)
from phonanim.core.files import atomic_path, make_folder_within, write_text
from phonanim.corpus.document import decode_track, decode_word
from phonanim.errors import CorpusError
from phonanim.speech.alignment import Interval
from phonanim.speech.phones import PhoneTrack, silent_track
from phonanim.targets import Clip, Source

Array = NDArray[np.float64]
INDEX, TEMPLATES = "corpus.json", "templates.safetensors"
TRIANGLES = "triangles"
LANDMARKS = "landmarks"


@dataclass(frozen=True)
class MotionClip:
    """A recording: `motion` is its array (frames, ...), `audio` its sound, if any.

    `track` is all silence where nothing is `aligned`. `emotion` is empty where the data set has none.
    """

    name: str
    subject: str
    split: str
    frames: int
    motion: Path
    audio: Path | None
    track: PhoneTrack
    words: tuple[Interval, ...] = ()
    aligned: bool = False
    emotion: str = ""


@dataclass(frozen=True)
class MotionCorpus:
    """Clips of one kind of motion; frame i of a clip is at i / fps seconds."""

    kind: str
    fps: float
    source: Source
    clips: tuple[MotionClip, ...]
    provenance: dict[str, Any] = field(default_factory=dict)

    def clips_of(self, *splits: str) -> NDArray[np.int64]:
        """Numbers of the clips in some splits."""
        return np.array([n for n, clip in enumerate(self.clips) if clip.split in splits], np.int64)

    def times(self, clip: int) -> Array:
        """Instants of the frames of a clip, (frames,) seconds."""
        return np.arange(self.clips[clip].frames) / self.fps

    def frames(self, clip: int) -> NDArray[np.floating]:
        """Frames of a clip, (frames, ...), read when they are used. Raises CorpusError."""
        one = self.clips[clip]
        try:
            values: NDArray[np.floating] = map_array(one.motion)
        except (OSError, DecodeError) as error:
            raise CorpusError(f"{one.motion}: cannot be read ({error}); import the data set again") from error
        if values.ndim < 2 or len(values) != one.frames or values.dtype.kind != "f":
            raise CorpusError(
                f"{one.motion}: has the shape {values.shape} of {values.dtype}, "
                f"not {one.frames} frames of float; build it again"
            )
        return values

    def finite_frames(self, clip: int) -> NDArray[np.floating]:
        """Frames of a clip to learn from. Raises CorpusError, which names the first that is not finite."""
        values = self.frames(clip)
        broken = np.flatnonzero(~np.isfinite(values.reshape(len(values), -1)).all(axis=1))
        if len(broken):
            raise CorpusError(
                f"{self.clips[clip].motion}: frame {broken[0]} has numbers that are not finite "
                f"({len(broken)} such frames); mend them or leave the recording out"
            )
        return values

    def rest(self, clip: int) -> Array | None:
        """The face at rest of the subject of a clip, (vertices, 3), if the corpus has one."""
        return self.source.templates.get(self.clips[clip].subject)

    def examples(self, clips: Iterable[int]) -> Iterable[Clip]:
        """Frames and the face at rest of some clips, one by one."""
        return ((self.finite_frames(int(clip)), self.rest(int(clip))) for clip in clips)


def corpus_kind(folder: Path) -> str:
    """What the frames of a corpus are: "landmarks", or a kind of phonanim.targets; "" where it is none."""
    try:
        document = read_json(folder / INDEX)
    except (OSError, *DAMAGE):
        return ""
    return str(document.get("kind", LANDMARKS)) if isinstance(document, dict) else ""


def has_own_motion(folder: Path) -> bool:
    """Whether a corpus is of controls, sensors or vertices, not of landmarks."""
    return corpus_kind(folder) not in ("", LANDMARKS)


def save_motion_corpus(corpus: MotionCorpus, folder: Path) -> None:
    """Write the index and the templates of a corpus, and links to its motion and sound from elsewhere.

    The links are hard, and copies where the file system has none. Raises OutputError.
    """
    from safetensors.numpy import save

    folder.mkdir(parents=True, exist_ok=True)
    arrays = {f"of {name}": rest.astype(np.float32) for name, rest in corpus.source.templates.items()}
    if corpus.source.triangles is not None:
        arrays[TRIANGLES] = corpus.source.triangles.astype(np.int32)
    if arrays:
        with atomic_path(folder / TEMPLATES) as path:
            path.write_bytes(save(arrays))
    document = {
        "kind": corpus.kind,
        "fps": corpus.fps,
        "data": corpus.source.data,
        "unit": corpus.source.unit,
        "names": list(corpus.source.names),
        "provenance": corpus.provenance,
        "clips": [_plain(clip, folder) for clip in corpus.clips],
    }
    write_text(folder / INDEX, json.dumps(document, indent=1, ensure_ascii=False) + "\n")


def _plain(clip: MotionClip, folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = {
        "clip": clip.name,
        "subject": clip.subject,
        "emotion": clip.emotion,
        "split": clip.split,
        "frames": clip.frames,
        "motion": _place_within(clip.motion, folder, "motion", clip.name),
        "audio": _place_within(clip.audio, folder, "audio", clip.name) if clip.audio else None,
    }
    if clip.aligned:
        found["words"] = [[word.label, word.start, word.end] for word in clip.words]
        found["codes"] = clip.track.codes.tolist()
        found["bounds"] = clip.track.bounds.tolist()
        found["labels"] = list(clip.track.labels)
    return found


def _place_within(path: Path, folder: Path, kind: str, name: str) -> str:
    """The path of a file from the folder of a corpus, which gets a link to it if it is elsewhere."""
    source, home = path.resolve(), folder.resolve()
    if source.is_relative_to(home):
        return source.relative_to(home).as_posix()
    target = home / kind / f"{name}{path.suffix}"
    make_folder_within(target.parent, home)
    with atomic_path(target) as partial:
        try:
            os.link(source, partial)
        except OSError:  # another file system, or one without links
            shutil.copyfile(source, partial)
    return target.relative_to(home).as_posix()


def load_motion_corpus(folder: Path) -> MotionCorpus:
    """Read what `save_motion_corpus` wrote. Raises CorpusError when it is missing or damaged."""
    try:
        document = decode_table(read_json(folder / INDEX), INDEX)
        arrays = read_tensors(folder / TEMPLATES) if (folder / TEMPLATES).is_file() else {}
        triangles = arrays.pop(TRIANGLES, None)
        fps = decode_rate(document["fps"])
        source = Source(
            decode_text(document["data"], "data"),
            tuple(decode_text(name, "a name") for name in decode_list(document["names"], "names")),
            decode_text(document["unit"], "unit"),
            {name.removeprefix("of "): rest.astype(np.float64) for name, rest in arrays.items()},
            None if triangles is None else triangles.astype(np.int64),
        )
        clips = tuple(
            _decode_clip(decode_table(clip, "a clip"), folder, fps)
            for clip in decode_list(document["clips"], "clips")
        )
        provenance = dict(decode_table(document["provenance"], "provenance"))
        return MotionCorpus(decode_text(document["kind"], "kind"), fps, source, clips, provenance)
    except (OSError, *DAMAGE) as error:
        raise CorpusError(
            f"{folder}: not a corpus ({error}); make one with `phonanim corpus build`"
        ) from error


def _decode_clip(clip: Mapping[str, Any], folder: Path, fps: float) -> MotionClip:
    frames = decode_whole(clip["frames"], "frames", 1, 1 << 31)
    aligned = "codes" in clip
    audio = clip["audio"]
    return MotionClip(
        decode_part(clip["clip"], "clip"),
        decode_text(clip["subject"], "subject"),
        decode_text(clip["split"], "split"),
        frames,
        folder / decode_path_below(clip["motion"], "motion"),
        folder / decode_path_below(audio, "audio") if audio is not None else None,
        decode_track(clip) if aligned else silent_track(frames / fps),
        tuple(map(decode_word, decode_list(clip["words"], "words"))) if aligned else (),
        aligned,
        decode_text(clip["emotion"], "emotion"),
    )
