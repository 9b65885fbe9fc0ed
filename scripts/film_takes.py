"""Draw takes of the same lines side by side, from the front and from the side, as an animated picture.

    phonanim batch lines/ -o direct/ --format glb --life 0 --retarget direct
    phonanim batch lines/ -o full/ --format glb --life 0
    python scripts/film_takes.py docs/images/sentences.webp \\
        --take landmarks direct/*.glb --take articulation full/*.glb

The lines of that picture are LJ001-0013, LJ001-0061 and LJ002-0044 of LJSpeech. Each take is a label and the
GLB files of its lines, which carry their own head; needs Pillow.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from phonanim.exporters import load
from phonanim.media.pixels import draw_text
from phonanim.rig.head import load_head
from phonanim.rig.render import lower_face, render

FPS = 12.5  # pictures per second
SIZE, YAWS, CAPTION = 150, (0.0, 40.0), 44  # pixels, degrees, pixels
SPAN = 0.8  # of the view of the lower face
PAPER, INK = 250, (20, 20, 20)
QUALITY = 62  # of WebP

Frames = NDArray[np.uint8]


def main() -> None:
    """Draw every line of every take, and write one animated picture."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("output", type=Path)
    options.add_argument("--take", nargs="+", action="append", required=True, metavar=("LABEL", "GLB"))
    chosen = options.parse_args()
    columns = [draw_take(label, [Path(name) for name in names]) for label, *names in chosen.take]
    count = min(map(len, columns))
    pictures = [Image.fromarray(np.hstack([column[n] for column in columns])) for n in range(count)]
    pictures[0].save(
        chosen.output, save_all=True, append_images=pictures[1:], duration=round(1000 / FPS), loop=0,
        quality=QUALITY, method=6,
    )  # fmt: skip


def draw_take(label: str, paths: list[Path]) -> list[Frames]:
    """Pictures of the lines of one take, one after the other, with the word that is spoken beneath."""
    return [frame for path in paths for frame in draw_line(label, path)]


def draw_line(label: str, path: Path) -> list[Frames]:
    """Pictures of one line, (height, width, 3) each."""
    line, head = load(path), load_head(path)
    times = np.arange(line.times[0], line.times[-1], 1 / FPS)
    rows = np.searchsorted(line.times, times - 1e-6)
    shapes = head.shape(head.weights(line.values[rows], line.channels))
    view = lower_face(head, SIZE)
    view = replace(view, span=SPAN * view.span)
    frames = []
    for time, shape in zip(times, shapes, strict=True):
        faces = np.hstack([render(shape, head, replace(view, yaw=yaw)) for yaw in YAWS])
        caption = np.full((CAPTION, faces.shape[1], 3), PAPER, np.uint8)
        word = next((word.label for word in line.words if word.start <= time < word.end), "")
        draw_text(caption, f"{label}: {word}", faces.shape[1] // 2, 12, INK, "large", align=0.5)
        frames.append(np.vstack([faces, caption]))
    return frames


if __name__ == "__main__":
    main()
