"""Draw a line as filmed, as the drawn mouth says it, and as heads say it.

    python scripts/plot_pipeline.py RECORDINGS/grid_s1 work/corpus work/mouth -o docs/images/pipeline.png

Taylor et al. 2017, figure 8: the film, the prediction of the appearance model, and the same line on rigs. The
shipped head comes first; `--character HEAD.glb` adds others that have ARKit's blendshapes. The columns are
the middles of the clip's longest phones.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from plot_mouths import columns, sheet

import phonanim
from phonanim.corpus.corpus import load_corpus
from phonanim.corpus.pictures import open_mouth_films
from phonanim.media.pixels import Image, write_png
from phonanim.rig.head import load_dressed_head
from phonanim.rig.portrait import load_portrait
from phonanim.rig.render import lower_face, render
from phonanim.training.mouth import load_mouth


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("recordings", "corpus", "mouth"):
        parser.add_argument(name, type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--clip", default="bbbs4n")
    parser.add_argument("--character", type=Path, action="append", default=[])
    args = parser.parse_args()
    corpus, mouth = load_corpus(args.corpus), load_mouth(args.mouth)
    model, clip = mouth.appearance, corpus.clips.index(args.clip)
    frames, labels = columns(corpus, clip)
    times, rows = corpus.times(clip)[frames], corpus.rows([clip])[frames]
    textures = open_mouth_films(args.recordings, corpus).cut(clip, model.face, model.rows, model.mesh)[1]
    line = args.recordings / "textgrid" / f"{args.clip}.TextGrid"
    pictures = {
        "film": model.draw(corpus.landmarks[rows].astype(float), textures[frames], 1.5),
        "predicted": model.render(mouth.predict(corpus.tracks[clip], times), 1.5),
    }
    size = pictures["film"].shape[2]
    pictures["head"] = on_head(line, times, None, size)
    pictures |= {path.stem[:9]: on_head(line, times, path, size) for path in args.character}
    write_png(np.vstack([sheet(name, row, labels) for name, row in pictures.items()]), args.output)


def on_head(line: Path, times: np.ndarray, character: Path | None, size: int) -> Image:
    """The lower face of a head at instants of a line, (times, size, size, 3)."""
    animation = phonanim.animate(line, rig="arkit", life=0.0)
    head = load_dressed_head()
    view = lower_face(head, size)
    if character is not None:
        portrait = load_portrait(character, animation.channels, size, size, view.yaw)
        head, view = portrait.head, portrait.view
    shown = animation.values[np.rint(times * animation.fps).astype(int)]
    shapes = head.shape(head.weights(shown, animation.channels))
    return np.stack([render(shape, head, view) for shape in shapes])


if __name__ == "__main__":
    main()
