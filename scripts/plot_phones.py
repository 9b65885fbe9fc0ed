"""Draw the shipped head in the middle of phones of natural speech, from the front and from the side.

    python scripts/plot_phones.py ALIGNMENTS -o phones.png [--rig arkit_tongue] [--retarget direct]

ALIGNMENTS is a folder of English files. Of each phone the one of median duration is drawn.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.media.pixels import draw_text, write_png
from phonanim.options import Options
from phonanim.pipeline import animate
from phonanim.rig.head import load_head
from phonanim.rig.render import View, lower_face, render

PHONES = ("AA", "AE", "IY", "UW", "W", "OW", "SH", "S", "F", "M", "TH", "L")
COLUMNS, SIZE, YAWS, CAPTION = 6, 200, {"front": 0.0, "side": 40.0}, 26  # pictures, pixels, degrees, pixels
SPAN = 0.68  # of the view of the lower face
PAPER, INK = 250, (20, 20, 20)
MARGIN = 56  # pixels, for the names of the rows


def main() -> None:
    """Pick the phones, move the head, draw it."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("alignments", type=Path)
    options.add_argument("-o", "--output", type=Path, required=True)
    options.add_argument("--rig", default="arkit_tongue")
    options.add_argument("--retarget", default="auto")
    options.add_argument("--files", type=int, default=80)
    chosen = options.parse_args()
    paths = sorted(chosen.alignments.rglob("*.TextGrid"))
    paths = paths[:: max(1, len(paths) // chosen.files)][: chosen.files]
    weights = picked(paths, Options(rig=chosen.rig, retarget=chosen.retarget))
    write_png(sheet(weights), chosen.output)


def picked(paths: list[Path], options: Options) -> NDArray[np.float64]:
    """Weights of the head's targets in the middle of each phone, (phones, targets)."""
    head = load_head()
    found: dict[str, list[tuple[float, Path, float]]] = {phone: [] for phone in PHONES}
    lines = {path: animate(path, options) for path in paths}
    for path, line in lines.items():
        for phone in line.phones:
            label = phone.label.rstrip("012")
            if label in found:
                found[label].append((phone.end - phone.start, path, (phone.start + phone.end) / 2))
    rows = []
    for phone in PHONES:
        if not found[phone]:
            raise SystemExit(f"no alignment has the phone {phone}; give more files")
        _, path, middle = sorted(found[phone])[len(found[phone]) // 2]
        line = lines[path]
        frame = round((middle - line.start) * line.fps)
        rows.append(head.weights(line.values[[frame]], line.channels)[0])
    return np.array(rows)


def sheet(weights: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Pictures in rows of COLUMNS phones, a row from the front and one from the side."""
    head = load_head()
    view: View = lower_face(head, SIZE)
    view = replace(view, span=SPAN * view.span)
    rows = []
    for start in range(0, len(weights), COLUMNS):
        shapes = head.shape(weights[start : start + COLUMNS])
        caption = np.full((CAPTION, MARGIN + SIZE * COLUMNS, 3), PAPER, np.uint8)
        for place, phone in enumerate(PHONES[start : start + COLUMNS]):
            draw_text(caption, phone, MARGIN + place * SIZE + SIZE // 2, 4, INK, "large", align=0.5)
        for name, yaw in YAWS.items():
            margin = np.full((SIZE, MARGIN, 3), PAPER, np.uint8)
            draw_text(margin, name, MARGIN // 2, SIZE // 2 - 8, INK, align=0.5)
            faces = [render(shape, head, replace(view, yaw=yaw)) for shape in shapes]
            rows.append(np.hstack([margin, *faces]))
        rows.append(caption)
    return np.vstack(rows)


if __name__ == "__main__":
    main()
