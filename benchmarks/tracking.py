"""How well films are tracked: the shipped head speaks, is filmed and tracked, and its own lips are the truth.

    phonanim animate LINE.TextGrid --audio LINE.flac --fps 25 -o films/LINE.mp4     (for some lines)
    phonanim corpus track films/*.mp4 -o recordings && phonanim corpus build recordings -o corpus
    python benchmarks/tracking.py corpus films

The folder of films holds LINE.TextGrid too.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.catalog import DEFAULT_MODEL, SHIPPED
from phonanim.corpus.corpus import load_corpus
from phonanim.face.model import lip_aperture, lip_width
from phonanim.metrics import correlation
from phonanim.options import Options
from phonanim.pipeline import animate
from phonanim.regressors import load_face
from phonanim.rig import load_rig
from phonanim.rig.head import load_head
from phonanim.rig.landmarks import read_landmarks


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("corpus", type=Path)
    options.add_argument("films", type=Path)
    chosen = options.parse_args()
    corpus, face = load_corpus(chosen.corpus), load_face(SHIPPED / DEFAULT_MODEL / "face.safetensors")
    for number, name in enumerate(corpus.clips):
        tracked = corpus.landmarks[corpus.rows([number])]
        truth = head_landmarks(chosen.films / f"{name}.TextGrid", corpus.fps)
        count = min(len(tracked), len(truth))
        aperture = truth[:count, 13, 1] - truth[:count, 14, 1]
        width = np.linalg.norm(truth[:count, 61] - truth[:count, 291], axis=1)
        print(
            f"{name}: aperture r {correlation(lip_aperture(tracked, face)[:count], aperture):.2f}, "
            f"width r {correlation(lip_width(tracked, face)[:count], width):.2f}"
        )


def head_landmarks(line: Path, fps: float) -> NDArray[np.float64]:
    """The landmarks of the shipped head as it speaks a line, (frames, 478, 3) mm."""
    head, spots = load_head(), read_landmarks(load_rig("arkit").landmarks)
    animation = animate(line, Options(fps=fps))
    weights = head.weights(animation.values, animation.channels)
    return np.stack([spots.of(head.shape(now)) for now in weights]) * 1000


if __name__ == "__main__":
    main()
