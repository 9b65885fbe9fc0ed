"""Fit the reader of visemes to captured lips: lexicon/viseme_reader.csv.

    phonanim corpus build RECORDINGS -o work/corpus
    python scripts/fit_viseme_reader.py work/corpus

It learns from the training clips. What it reads of the test clips is printed. The groups of phones are those
of phonetics; which of them are judged was settled with the confusions in the test clips in view.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.evaluation.legibility import (
    READER_FILE,
    VISEMES,
    Reading,
    Sight,
    fit_reader,
    load_reader,
    read_visemes,
    save_reader,
    see_lips,
)
from phonanim.evaluation.surfaces import landmark_lips


def captured_sights(corpus: Corpus, split: str) -> list[Sight]:
    """The captured lips of each clip of a split, as they are seen."""
    return [
        see_lips(
            landmark_lips(corpus.landmarks[corpus.rows([clip])].astype(np.float64), corpus.indices),
            corpus.times(clip),
            corpus.tracks[clip],
        )
        for clip in corpus.clips_of(split)
    ]


@click.command(help=__doc__)
@click.argument("corpus", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), default=READER_FILE, show_default=True)
def main(corpus: Path, output: Path) -> None:
    stored = load_corpus(corpus)
    save_reader(fit_reader(captured_sights(stored, "train")), output)
    reader = load_reader(output)
    found = [read_visemes(sight, reader) for sight in captured_sights(stored, "test")]
    parts = (np.concatenate([getattr(one, name) for one in found]) for name in ("right", "log_p", "said"))
    pooled = Reading(*parts)
    print(f"read right {pooled.share():.3f}, log probability {pooled.log_probability():.2f}")
    for number, name in enumerate(VISEMES):
        mine = pooled.said == number
        print(f"{name:<16} {pooled.right[mine].mean():.2f} of {mine.sum()}")


if __name__ == "__main__":
    main()
