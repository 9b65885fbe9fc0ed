"""Draw the first four modes of the reference face at minus and plus three standard deviations.

python scripts/plot_modes.py phonanim/models/default -o docs/images/modes.png
"""

from __future__ import annotations

from pathlib import Path

import click
import matplotlib
import numpy as np

from phonanim.face.model import INNER_LIPS, OUTER_LIPS, FaceModel
from phonanim.metrics import lip_gap
from phonanim.regressors import load_face

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

SIGMAS = 3.0


def draw(axes: Axes, shape: np.ndarray, face: FaceModel, title: str) -> None:
    """Lips as closed curves, everything else as points, seen from the front.

    Where a mode goes beyond closed lips, the inner rims cross: no mouth is drawn there.
    """
    axes.scatter(shape[:, 0], shape[:, 1], s=4, color="#b0a8a0", linewidths=0)
    is_open = lip_gap(shape[None], face)[0] > 0
    for ring, colour in ((OUTER_LIPS, "#e8a79b"), (INNER_LIPS, "#5b2730" if is_open else "none")):
        points = shape[face.rows(ring)]
        axes.fill(points[:, 0], points[:, 1], color=colour, edgecolor="#7d3c3c", linewidth=0.8)
    axes.set(xlim=(-48, 48), ylim=(-118, -48), aspect="equal")
    axes.set_title(title, fontsize=9)
    axes.axis("off")


@click.command(help=__doc__)
@click.argument("model", type=click.Path(exists=True, path_type=Path))
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path))
def main(model: Path, output: Path) -> None:
    """Two rows, -3 and +3 standard deviations; the mean face at the left."""
    face = load_face(model / "face.safetensors")
    energy = face.std**2 / (face.std**2).sum()
    figure, grid = plt.subplots(2, 5, figsize=(11, 3.9), layout="constrained")
    draw(grid[0, 0], face.mean, face, "mean")
    grid[1, 0].axis("off")
    for mode in range(4):
        for row, sign in enumerate((-1, 1)):
            weights = np.zeros((1, len(face.std)))
            weights[0, mode] = sign * SIGMAS * face.std[mode]
            title = f"mode {mode + 1} ({energy[mode]:.0%}), {'+' if sign > 0 else '−'}3σ"
            draw(grid[row, mode + 1], face.instance(weights)[0], face, title)
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
