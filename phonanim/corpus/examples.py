"""Convert clips of a corpus into the examples that a regressor is trained on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import NDArray

from phonanim.corpus.corpus import Corpus
from phonanim.corpus.motion import MotionClip, MotionCorpus
from phonanim.errors import CorpusError
from phonanim.face.model import FaceModel
from phonanim.media.audio import Sound, read_sound
from phonanim.regressors import Examples
from phonanim.targets import Target


def make_examples(
    corpus: Corpus, face: FaceModel, clips: Iterable[int], with_sound: bool = False
) -> Examples:
    """Clips of a corpus as training examples: modes of the captured face at mid-exposure instants.

    With `with_sound`, the recordings are included. Raises AudioError when one cannot be read.
    """
    chosen = [int(clip) for clip in clips]
    return Examples(
        tuple(corpus.tracks[clip] for clip in chosen),
        tuple(corpus.times(clip) for clip in chosen),
        tuple(face.project(corpus.landmarks[corpus.rows([clip])]).astype(np.float32) for clip in chosen),
        (1.0,) * len(chosen),
        tuple(read_sound(corpus.audio[clip]) for clip in chosen) if with_sound else (),
    )


@dataclass(frozen=True)
class EncodedClips(Sequence[NDArray[np.float32]]):
    """Rows of the frames of clips, (frames, m) each, made from the disk whenever they are asked for."""

    corpus: MotionCorpus
    target: Target
    clips: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.clips)

    @overload
    def __getitem__(self, place: int) -> NDArray[np.float32]: ...

    @overload
    def __getitem__(self, place: slice) -> Sequence[NDArray[np.float32]]: ...

    def __getitem__(self, place: int | slice) -> NDArray[np.float32] | Sequence[NDArray[np.float32]]:
        """The rows of one clip, or a part of the clips."""
        if isinstance(place, slice):
            return EncodedClips(self.corpus, self.target, self.clips[place])
        clip = self.clips[place]
        return self.target.encode(self.corpus.finite_frames(clip), self.corpus.rest(clip))


def motion_examples(
    corpus: MotionCorpus, target: Target, clips: Iterable[int], styles: Sequence[str] = (), by: str = "none"
) -> Examples:
    """Clips of other motion than landmarks as training examples; their rows are made on demand.

    `styles` are the names of the styles that a model tells apart `by` speaker, emotion or both. Sounds are
    read where every clip has one. Raises AudioError when one cannot be read.
    """
    chosen = tuple(int(clip) for clip in clips)
    ones = [corpus.clips[clip] for clip in chosen]
    with_sound = all(one.audio for one in ones)
    return Examples(
        tuple(one.track for one in ones),
        tuple(corpus.times(clip) for clip in chosen),
        EncodedClips(corpus, target, chosen),
        (1.0,) * len(chosen),
        tuple(read_clip_sound(one) for one in ones) if with_sound else (),
        tuple(style_number(style_name(one, by), styles) for one in ones) if styles else (),
    )


def read_clip_sound(clip: MotionClip) -> Sound:
    """The sound of a clip. Raises CorpusError without one, AudioError when it cannot be read."""
    if clip.audio is None:
        raise CorpusError(f"{clip.name}: has no sound, which this model needs")
    return read_sound(clip.audio)


def style_name(clip: MotionClip, by: str) -> str:
    """The style of a clip: its speaker, its emotion, both, or none."""
    parts = {"speaker": (clip.subject,), "emotion": (clip.emotion,)}
    return " ".join(
        parts.get(by, (clip.subject, clip.emotion) if by == "speaker and emotion" else ())
    ).strip()


def style_number(name: str, styles: Sequence[str]) -> int:
    """The place of a style; the first style for one that training lacks, as of a speaker of a test."""
    return styles.index(name) if name in styles else 0
