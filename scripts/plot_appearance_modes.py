"""Draw the first three joint modes of shape and appearance at minus and plus three standard deviations.

    phonanim corpus appearance RECORDINGS/grid_s1 --corpus work/corpus
    python scripts/plot_appearance_modes.py work/corpus/appearance -o docs/images/appearance_modes.png

Taylor et al. 2017, figure 3c.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from phonanim.face.appearance import BACKDROP, load_appearance
from phonanim.media.pixels import Image, draw_text, write_png

MODES, SIGMAS, SCALE = 3, 3.0, 2.0
MARGIN, CAPTION = 60, 26  # pixels, for the names of rows and of columns
PAPER, INK = 250, (20, 20, 20)


@click.command(help=__doc__)
@click.argument("appearance", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("-o", "--output", required=True, type=click.Path(dir_okay=False, path_type=Path))
def main(appearance: Path, output: Path) -> None:
    """Two rows, -3 and +3 standard deviations; the mean at the left."""
    model = load_appearance(appearance)
    energy = model.std**2 / (model.std**2).sum()
    joint = np.zeros((2 * MODES + 1, len(model.std)))
    for mode in range(MODES):
        joint[2 * mode + 1 : 2 * mode + 3, mode] = (-SIGMAS * model.std[mode], SIGMAS * model.std[mode])
    mean, *others = model.render(joint, SCALE)
    titles = ["mean", *(f"mode {mode + 1} ({energy[mode]:.0%})" for mode in range(MODES))]
    grid = [[mean, *others[0::2]], [np.full_like(mean, PAPER), *others[1::2]]]
    write_png(np.vstack([titles_row(titles, mean.shape[1]), *map(row, ("-3 sd", "+3 sd"), grid)]), output)


def titles_row(titles: list[str], width: int) -> Image:
    """The names of the columns."""
    drawn = np.full((CAPTION, MARGIN + len(titles) * width, 3), PAPER, np.uint8)
    for place, title in enumerate(titles):
        draw_text(drawn, title, MARGIN + (place + 0.5) * width, 4, INK, align=0.5)
    return drawn


def row(name: str, pictures: list[Image]) -> Image:
    """Pictures side by side on white, with their name at the left."""
    height, width = pictures[0].shape[:2]
    drawn = np.full((height, MARGIN + len(pictures) * width, 3), PAPER, np.uint8)
    draw_text(drawn, name, MARGIN // 2, height // 2, INK, align=0.5)
    for place, picture in enumerate(pictures):
        left = MARGIN + place * width
        hidden = (picture == BACKDROP).all(axis=-1, keepdims=True)
        drawn[:, left : left + width] = np.where(hidden, np.uint8(PAPER), picture)
    return drawn


if __name__ == "__main__":
    main()
