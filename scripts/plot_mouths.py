"""Draw one test clip three times over: as filmed, as the model can show it, and as it is predicted.

    python scripts/plot_mouths.py RECORDINGS/grid_s1 work/corpus work/mouth -o docs/images/mouths.png

The columns are the middles of the clip's phones, the longest first until the picture is full.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.corpus.pictures import load_captured, open_mouth_films
from phonanim.face.appearance import BACKDROP
from phonanim.media.pixels import draw_text, write_png
from phonanim.speech.labels import is_silent
from phonanim.training.mouth import load_mouth

WIDTH = 8  # pictures
ROWS = ("film", "model", "predicted")
MARGIN, CAPTION = 76, 22  # pixels, for the names of rows and of phones
PAPER, INK = 250, (20, 20, 20)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("recordings", "corpus", "mouth"):
        parser.add_argument(name, type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--clip", default="bbbs4n")
    args = parser.parse_args()
    corpus, mouth = load_corpus(args.corpus), load_mouth(args.mouth)
    captured, model = load_captured(args.corpus), mouth.appearance
    clip = corpus.clips.index(args.clip)
    frames, labels = columns(corpus, clip)
    films = open_mouth_films(args.recordings, corpus)
    textures = films.cut(clip, model.face, model.rows, model.mesh)[1][frames]
    rows = corpus.rows([clip])[frames]
    joint = mouth.predict(corpus.tracks[clip], corpus.times(clip)[frames])
    pictures = (
        model.draw(corpus.landmarks[rows].astype(float), textures, 1.5),
        model.render(captured.joint[rows], 1.5),
        model.render(joint, 1.5),
    )
    sheets = [sheet(name, row, labels) for name, row in zip(ROWS, pictures, strict=True)]
    write_png(np.vstack(sheets), args.output)


def sheet(name: str, pictures: NDArray[np.uint8], labels: list[str]) -> NDArray[np.uint8]:
    """A row of pictures, (n, rows, columns, 3), on white, with its name at the left and labels below."""
    count, height, width = pictures.shape[:3]
    drawn = np.full((height + CAPTION, MARGIN + count * width, 3), PAPER, np.uint8)
    draw_text(drawn, name, MARGIN // 2, height // 2, INK, align=0.5)
    for place, (picture, label) in enumerate(zip(pictures, labels, strict=True)):
        left = MARGIN + place * width
        drawn[:height, left : left + width] = np.where(is_backdrop(picture), np.uint8(PAPER), picture)
        draw_text(drawn, label, left + width / 2, height, INK, align=0.5)
    return drawn


def is_backdrop(picture: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Where a picture, (rows, columns, 3), shows no face; -> (rows, columns, 1)."""
    return np.asarray((picture == BACKDROP).all(axis=-1, keepdims=True))


def columns(corpus: Corpus, clip: int) -> tuple[NDArray[np.int64], list[str]]:
    """Frames of a clip in the middle of its longest phones, in their order, and the phones' labels."""
    track = corpus.tracks[clip]
    spoken = np.array([not is_silent(label) for label in track.labels])
    longest = np.argsort(-np.where(spoken, np.diff(track.bounds), 0), kind="stable")[
        : min(WIDTH, spoken.sum())
    ]
    chosen = np.sort(longest)
    middles = (track.bounds[chosen] + track.bounds[chosen + 1]) / 2
    frames = np.minimum((middles * corpus.fps).astype(np.int64), corpus.frames[clip] - 1)
    return frames, [track.labels[n] for n in chosen]


if __name__ == "__main__":
    main()
