"""Draw how sliding windows make a curve (Taylor 2017, figure 4): phones in, windows out, their mean.

    python scripts/plot_windows.py work/corpus -o docs/images/windows.png

A decision tree on raw phones (Kx 11, Ky 5) is grown on a few training clips for the picture.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from phonanim.core.files import atomic_path
from phonanim.corpus.corpus import load_corpus
from phonanim.corpus.examples import make_examples
from phonanim.face.fit import fit_face
from phonanim.features.inputs import window_features
from phonanim.features.windows import overlap_mean
from phonanim.regressors.tree import Config, Forest
from phonanim.speech.inventory import INVENTORY

CLIPS = 200  # training clips of the tree
REACH, WIDTH = 11, 5  # frames in and out: Kx and Ky
AT = 0.55  # of the clip: the frame whose windows are marked
DOTS = 100  # per inch


def draw(figure: Any, phones: Any, windows: Any, captured: Any) -> None:
    """Phones of every frame, the predicted windows of the first mode, and their mean beside the capture."""
    frames, marked = np.arange(len(captured)), round(AT * len(captured))
    above, middle, below = figure.subplots(3, 1, sharex=True, height_ratios=[0.5, 1, 1])
    names = [INVENTORY.phones[code] for code in phones]
    for frame, name in enumerate(names):
        above.text(frame, 0.5, name, ha="center", va="center", fontsize=7, rotation=90)
    above.axvspan(marked - REACH / 2, marked + REACH / 2, color="#D55E00", alpha=0.3)
    above.set(yticks=[], ylabel="phones")
    above.set_title(f"window in: {REACH} frames around frame {marked}", fontsize="medium")
    for frame in frames:
        reach = np.arange(WIDTH) - WIDTH // 2
        shade = (
            {"color": "#D55E00", "linewidth": 2.5, "zorder": 3} if frame == marked else {"color": "#56B4E9"}
        )
        middle.plot(frame + reach, windows[frame, :, 0], **{"linewidth": 0.9, **shade})
    middle.set(ylabel="mode 1, mm")
    middle.set_title(f"windows out: {WIDTH} frames for each frame", fontsize="medium")
    below.plot(frames, captured[:, 0], color="black", linewidth=1, label="captured")
    below.plot(
        frames, overlap_mean(windows)[:, 0], color="#0072B2", linewidth=1.8, label="mean of the windows"
    )
    below.set(xlabel="frame (25 per second)", ylabel="mode 1, mm", xlim=(-0.5, len(frames) - 0.5))
    below.set_title("their mean in each frame", fontsize="medium")
    below.legend(fontsize="small")


@click.command(help=__doc__)
@click.argument("corpus", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), required=True)
def main(corpus: Path, output: Path) -> None:
    """Grow the tree and draw the first test clip."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    read = load_corpus(corpus)
    train, clip = read.clips_of("train")[:CLIPS], int(read.clips_of("test")[0])
    face = fit_face(read.landmarks[read.rows(train)], read.indices)
    examples, rng = make_examples(read, face, train), np.random.default_rng(0)
    tree = Forest.fit(Config(features="raw", width=WIDTH), examples, examples, rng, lambda done: None)
    track, times = read.tracks[clip], read.times(clip)
    windows = tree.descend(window_features("raw", track, times)).reshape(len(times), WIDTH, -1)
    figure = Figure(figsize=(9, 6), layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure, track.sample(times), windows, face.project(read.landmarks[read.rows([clip])]))
    with atomic_path(output) as unfinished:
        figure.savefig(unfinished, dpi=DOTS, format="png", metadata={"Software": None})


if __name__ == "__main__":
    main()
