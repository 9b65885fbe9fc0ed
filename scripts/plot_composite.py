"""Draw a test clip as filmed, and with the predicted mouth drawn onto the film.

    python scripts/plot_composite.py RECORDINGS/grid_s1 work/corpus work/mouth -o docs/images/composite.png

Taylor et al. 2017, figure 7. The predicted shape is put where the filmed head is, the predicted picture gets
the light of the clip, and its border fades into the film. The columns are the middles of the clip's longest
phones.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from plot_mouths import columns, sheet

from phonanim.corpus.corpus import load_corpus
from phonanim.corpus.pictures import open_mouth_films
from phonanim.face.appearance import AppearanceModel
from phonanim.media.pixels import Image, write_png
from phonanim.training.mouth import load_mouth

SCALE = 2  # of the film
ROOM = 12  # pixels of the drawn film around the face
FADE = 8  # pixels of the drawn film over which the border fades

Array = NDArray[np.float64]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("recordings", "corpus", "mouth"):
        parser.add_argument(name, type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--clip", default="bbbs4n")
    args = parser.parse_args()
    corpus, mouth = load_corpus(args.corpus), load_mouth(args.mouth)
    model, clip = mouth.appearance, corpus.clips.index(args.clip)
    frames, labels = columns(corpus, clip)
    films = open_mouth_films(args.recordings, corpus)
    rows = corpus.rows([clip])
    shapes, textures = films.cut(clip, model.face, model.rows, model.mesh)
    light = (textures - model.without_light(textures, shapes)).mean(axis=0)
    joint = mouth.predict(corpus.tracks[clip], corpus.times(clip)[frames])
    modes, predicted = model.instance(joint)
    filmed = enlarged(films.film(clip)[frames])
    captured, places = corpus.landmarks[rows][frames], films.landmarks[rows][frames]
    seen = [seen_at(*pair) for pair in zip(captured, places, model.face.instance(modes), strict=True)]
    drawn = np.stack(
        [
            onto_film(model, texture + light, points[model.rows] * SCALE, film)
            for texture, points, film in zip(predicted, seen, filmed, strict=True)
        ]
    )
    down, across = around(places * SCALE, filmed.shape[1:3])
    shown = (("film", filmed[:, down, across]), ("predicted", drawn[:, down, across]))
    sheets = [sheet(name, row, labels) for name, row in shown]
    write_png(np.vstack(sheets), args.output)


def around(places: Array, size: tuple[int, int]) -> tuple[slice, slice]:
    """The rows and columns of a picture of a size that show all places (n, landmarks, 2), and a margin."""
    low, high = places.min(axis=(0, 1)) - ROOM, places.max(axis=(0, 1)) + ROOM
    across, down = (
        slice(max(int(start), 0), min(int(end), most))
        for start, end, most in zip(low, high, size[::-1], strict=True)
    )
    return down, across


def seen_at(captured: Array, places: Array, shape: Array) -> Array:
    """Where a shape (landmarks, 3) mm is seen, (landmarks, 2) pixels, by the pose of the captured one.

    The camera is affine: the least squares of the captured landmarks and their `places` in the film.
    """
    known = np.column_stack([captured, np.ones(len(captured))])
    camera = np.linalg.lstsq(known, places, rcond=None)[0]
    return np.asarray(np.column_stack([shape, np.ones(len(shape))]) @ camera)


def onto_film(model: AppearanceModel, texture: NDArray[np.float32], points: Array, film: Image) -> Image:
    """A texture (p, 3) drawn at points (landmarks, 2) of a picture, faded into it at its border."""
    centred = points + (SCALE - 1) / 2
    drawn = model.mesh.draw(texture, centred, film).astype(np.float32)
    covered = model.mesh.draw(np.full_like(texture, 255), centred, np.zeros_like(film))[..., 0] > 0
    inside, share = covered, np.zeros(film.shape[:2], np.float32)
    for _ in range(FADE):
        inside = inside & shifted(inside, 1, 0) & shifted(inside, -1, 0)
        inside = inside & shifted(inside, 0, 1) & shifted(inside, 0, -1)
        share += inside / np.float32(FADE)
    mixed = film + share[..., None] * (drawn - film)
    return np.asarray(np.rint(mixed), np.uint8)


def shifted(mask: NDArray[np.bool_], down: int, right: int) -> NDArray[np.bool_]:
    """A mask moved by a pixel; nothing comes in from the other side."""
    padded = np.pad(mask, 1)
    height, width = mask.shape
    return padded[1 + down : 1 + down + height, 1 + right : 1 + right + width]


def enlarged(pictures: Image) -> Image:
    """Pictures (n, rows, columns, 3) at SCALE times their size, interpolated."""
    found = pictures.astype(np.float32)
    for axis in (1, 2):
        size = found.shape[axis]
        at = np.clip((np.arange(size * SCALE) + 0.5) / SCALE - 0.5, 0, size - 1)
        below = np.minimum(at.astype(int), size - 2)
        share = (at - below).reshape([-1 if axis == n else 1 for n in range(4)]).astype(np.float32)
        found = np.take(found, below, axis) * (1 - share) + np.take(found, below + 1, axis) * share
    return np.asarray(np.rint(found), np.uint8)


if __name__ == "__main__":
    main()
