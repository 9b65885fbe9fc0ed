"""How much of the landmarks' motion follows the head's pose from clip to clip, before and after its removal.

python benchmarks/pose_leak.py RECORDINGS/grid_s1 --model phonanim/models/default --corpus work/corpus
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from phonanim import regressors
from phonanim.corpus.corpus import load_corpus, read_clips, read_landmarks, remove_pose_leak, stabilize
from phonanim.face.model import SUBNASALE
from phonanim.metrics import vertex_error


def facts(shapes: NDArray[np.float64], frames: NDArray[np.int64], train: NDArray[np.bool_]) -> str:
    """Error of the mean pose on the test clips, and the share of variance that lies between clips."""
    moved = shapes - shapes[train].mean(axis=0)
    starts = np.concatenate([[0], np.cumsum(frames)[:-1]])
    means = np.add.reduceat(moved, starts, axis=0) / frames[:, None, None]
    error = np.linalg.norm(moved[~train], axis=2).mean()
    between = (means**2).sum(axis=-1).mean() / (moved**2).sum(axis=-1).mean()
    return f"mean pose {error:.3f} mm on the test clips; {between:.1%} of the variance between clips"


@click.command(help=__doc__)
@click.argument("recordings", type=click.Path(exists=True, path_type=Path))
@click.option("--model", type=click.Path(exists=True, path_type=Path), help="Also score a model on both.")
@click.option("--corpus", "folder", type=click.Path(exists=True, path_type=Path), help="For --model.")
def main(recordings: Path, model: Path | None, folder: Path | None) -> None:
    """Stabilize, then remove the leak; moving landmarks only."""
    rows = read_clips(recordings)
    points, indices, _ = read_landmarks(recordings, rows)
    frames = np.array([int(row["frames"]) for row in rows])
    train = np.repeat([row["split"] == "train" for row in rows], frames)
    shapes, pose = stabilize(points, indices, train)
    moving = shapes[train].mean(axis=0)[:, 1] < shapes[train].mean(axis=0)[indices == SUBNASALE, 1]
    freed = remove_pose_leak(shapes, pose, frames, train)
    print("stabilized:      ", facts(shapes[:, moving], frames, train))
    print("leak removed too:", facts(freed[:, moving], frames, train))
    if model and folder:
        loaded, corpus = regressors.load(model), load_corpus(folder)
        clips = corpus.clips_of("test")
        predicted = np.concatenate(
            [loaded.regressor.predict(corpus.tracks[c], corpus.times(c)) for c in clips]
        )
        found = loaded.face.instance(predicted)
        for name, captured in (("stabilized", shapes), ("leak removed too", freed)):
            error = vertex_error(found, captured[corpus.rows(clips)], loaded.face).mean()
            print(f"the model's vertex error against landmarks, {name}: {error:.3f} mm")


if __name__ == "__main__":
    main()
