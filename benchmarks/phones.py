"""What the lips do in the middle of each phone of the recordings: the numbers behind the contacts.

python benchmarks/phones.py work/corpus
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from phonanim.corpus.corpus import load_corpus
from phonanim.face.fit import fit_face
from phonanim.face.model import lip_aperture, lip_width
from phonanim.metrics import phone_middles, vertex_error
from phonanim.speech.inventory import INVENTORY


@click.command(help=__doc__)
@click.argument("folder", type=click.Path(exists=True, path_type=Path))
def main(folder: Path) -> None:
    """What the modes leave; quartiles of aperture and width over the training clips, per phone."""
    corpus = load_corpus(folder)
    clips = corpus.clips_of("train")
    face = fit_face(corpus.landmarks[corpus.rows(clips)], corpus.indices)
    captured = corpus.landmarks[corpus.rows(corpus.clips_of("test"))]
    left = vertex_error(face.instance(face.project(captured)), captured, face).mean()
    print(f"{len(face.std)} modes leave {left:.2f} mm of vertex error on the test clips.\n")
    print("| phone | n | aperture, mm: quartiles | width, mm: quartiles |\n|---|---:|---|---|")
    for phone in INVENTORY.phones:
        rows = []
        for clip in clips:
            frames = np.round(phone_middles(corpus.tracks[clip], (phone,)) * corpus.fps - 0.5).astype(int)
            rows += [corpus.starts[clip] + frames.clip(0, corpus.frames[clip] - 1)]
        shapes = corpus.landmarks[np.concatenate(rows)]
        if len(shapes):
            told = [
                ", ".join(f"{q:.2f}" for q in np.percentile(measure(shapes, face), (25, 50, 75)))
                for measure in (lip_aperture, lip_width)
            ]
            print(f"| {phone} | {len(shapes)} | {told[0]} | {told[1]} |")


if __name__ == "__main__":
    main()
