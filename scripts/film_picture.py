"""Turn a film that phonanim wrote into an animated picture for a page.

    phonanim animate examples/line.TextGrid -o line.mp4
    python scripts/film_picture.py line.mp4 docs/images/line.webp

Needs phonanim[video].
"""

from __future__ import annotations

import argparse
from pathlib import Path

import av

FPS = 15.0  # pictures per second
SIZE = 320  # pixels
QUALITY = 60  # of WebP


def main() -> None:
    """Read every picture of the film that is shown at FPS, make it smaller, and write them all."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("film", type=Path)
    options.add_argument("output", type=Path)
    chosen = options.parse_args()
    pictures, due = [], 0.0
    with av.open(str(chosen.film)) as film:
        for frame in film.decode(video=0):
            if frame.time >= due - 1e-6:
                pictures.append(frame.to_image().resize((SIZE, SIZE)))
                due += 1 / FPS
    pictures[0].save(
        chosen.output, save_all=True, append_images=pictures[1:], duration=round(1000 / FPS), loop=0,
        quality=QUALITY, method=6,
    )  # fmt: skip


if __name__ == "__main__":
    main()
