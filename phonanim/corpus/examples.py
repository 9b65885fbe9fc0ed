"""Convert clips of a corpus into the examples that a regressor is trained on."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from phonanim.corpus.corpus import Corpus
from phonanim.face.model import FaceModel
from phonanim.media.audio import read_sound
from phonanim.regressors import Examples


def make_examples(corpus: Corpus, face: FaceModel, clips: Iterable[int], heard: bool = False) -> Examples:
    """Clips of a corpus as training examples: modes of the captured face at mid-exposure instants.

    With `heard`, the recordings are included. Raises AudioError when one cannot be read.
    """
    chosen = [int(clip) for clip in clips]
    return Examples(
        tuple(corpus.tracks[clip] for clip in chosen),
        tuple(corpus.times(clip) for clip in chosen),
        tuple(face.project(corpus.landmarks[corpus.rows([clip])]).astype(np.float32) for clip in chosen),
        (1.0,) * len(chosen),
        tuple(read_sound(corpus.audio[clip]) for clip in chosen) if heard else (),
    )
