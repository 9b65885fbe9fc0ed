"""Draw how a face moves, captured and predicted: maps of its motion, and statistics of its modes.

    python scripts/plot_motion.py work/corpus -o docs/images --model phonanim/models/default

- motion_maps.png: mean and standard deviation of each landmark's distance from the mean face, over the speech
  of the test clips (Stan 2023, figures 16 and 17), in millimetres;
- parameters.png: mean, deviation and the 1st to 99th percentile of each mode (Taylor 2017, figure 3b; Medina
  2023, chapter 4), captured and predicted.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from phonanim.comparison.folds import speech_frames
from phonanim.comparison.plots import SERIES
from phonanim.core.catalog import DEFAULT_MODEL
from phonanim.core.files import atomic_path
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.regressors import Model, load
from phonanim.training.recipes import predict_clip

Floats = NDArray[np.floating]
EXTREMES = 1, 99  # percentiles
DOTS = 100  # per inch


def speech_modes(corpus: Corpus, model: Model) -> tuple[Floats, Floats]:
    """Captured and predicted modes in the speech of the test clips, (frames, modes) each."""
    captured, predicted = [], []
    for clip in corpus.clips_of("test").tolist():
        spoken = speech_frames(corpus, clip)
        captured.append(model.face.project(corpus.landmarks[corpus.rows([clip])])[spoken])
        predicted.append(predict_clip(model.regressor, corpus, clip)[spoken])
    return np.concatenate(captured), np.concatenate(predicted)


def draw_maps(figure: Any, model: Model, kinds: dict[str, Floats], speech: str) -> None:
    """A face for each kind of motion: the mean displacement above, its deviation below."""
    measures = {"mean, mm": np.mean, "deviation, mm": np.std}
    panels = figure.subplots(len(measures), len(kinds), sharex=True, sharey=True)
    place = model.face.instance(np.zeros((1, len(model.face.std)), np.float32))[0]
    for row, (label, measure) in zip(panels, measures.items(), strict=True):
        values = {
            kind: measure(np.linalg.norm(model.face.instance(modes) - place, axis=2), axis=0)
            for kind, modes in kinds.items()
        }
        most = max(float(found.max()) for found in values.values())
        for axes, (kind, found) in zip(row, values.items(), strict=True):
            dots = axes.scatter(*place[:, :2].T, c=found, s=22, cmap="viridis", vmin=0, vmax=most)
            axes.set(aspect="equal", title=f"{kind}: {label}", xlabel="left, mm", ylabel="up, mm")
        figure.colorbar(dots, ax=list(row), label=label)
    figure.suptitle(f"Distance from the mean face in {speech}", fontsize="medium")


def draw_modes(figure: Any, kinds: dict[str, Floats], speech: str) -> None:
    """Mean and deviation of every mode, and its percentiles, beside each other."""
    axes = figure.subplots()
    for number, (kind, modes) in enumerate(kinds.items()):
        places = np.arange(modes.shape[1]) + 0.36 * number - 0.18
        low, high = np.percentile(modes, EXTREMES, axis=0)
        colour, mean, deviation = SERIES[number], modes.mean(axis=0), modes.std(axis=0)
        axes.vlines(places, low, high, color=colour, linewidth=1)
        axes.bar(places, 2 * deviation, 0.3, bottom=mean - deviation, color=colour, label=kind)
        axes.plot(places, mean, "_", color="black", markersize=8)
    axes.axhline(0, color="grey", linewidth=0.5)
    axes.set_xticks(np.arange(modes.shape[1]), np.arange(modes.shape[1]) + 1)
    axes.set(
        xlabel="mode (box: mean and deviation; line: 1st to 99th percentile)",
        ylabel="value, mm",
        title=f"Modes in {speech}",
    )
    axes.legend()


def save(figure: Any, path: Path) -> None:
    """Write a figure as PNG, to the same bytes every time."""
    with atomic_path(path) as unfinished:
        figure.savefig(unfinished, dpi=DOTS, format="png", metadata={"Software": None})


@click.command(help=__doc__)
@click.argument("corpus", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--model", type=click.Path(exists=True, path_type=Path), default="phonanim/models/default")
@click.option("-o", "--output", type=click.Path(file_okay=False, path_type=Path), required=True)
def main(corpus: Path, model: Path, output: Path) -> None:
    """Draw both figures."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    read, shown = load_corpus(corpus), load(model)
    kinds = dict(
        zip(
            ("captured", "phonanim" if model.name == DEFAULT_MODEL else model.name),
            speech_modes(read, shown),
            strict=True,
        )
    )
    seconds = len(kinds["captured"]) / read.fps
    speech = f"{seconds:.0f} s of speech, {Path(read.provenance.get('source', corpus)).name}"
    maps, modes = Figure(figsize=(8, 6.4), layout="constrained"), Figure(figsize=(8, 4), layout="constrained")
    for figure in (maps, modes):
        FigureCanvasAgg(figure)
    draw_maps(maps, shown, kinds, speech)
    draw_modes(modes, kinds, speech)
    output.mkdir(parents=True, exist_ok=True)
    save(maps, output / "motion_maps.png")
    save(modes, output / "parameters.png")


if __name__ == "__main__":
    main()
