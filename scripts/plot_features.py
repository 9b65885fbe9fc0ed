"""Draw what the encoders make of a line, as heat maps over time, with its phones (Medina 2023, figure 3.2).

    python scripts/plot_features.py examples/line.TextGrid -o docs/images/features.png

Each row is one feature of the last layer of its encoder, standardized over the line. Encoders without weights
are left out and named.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from phonanim.core.files import atomic_path
from phonanim.encoders import Features, encode, load_encoder
from phonanim.encoders.phones import track_features
from phonanim.errors import PhonanimError
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import find_audio, read_sound
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack

ENCODERS = ("mfcc", "whisper", "hubert", "wavlm", "wav2vec2")
DOTS, REACH = 100, 2.5  # per inch; deviations at the ends of the colours


def draw(figure: Any, features: dict[str, Features], track: PhoneTrack) -> None:
    """A panel for each encoder, the phones on top."""
    every = figure.subplots(len(features), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (name, found) in zip(every, features.items(), strict=True):
        values = np.asarray(found.values[:, -1], np.float64).T
        spread = values.std(axis=1, keepdims=True)
        standard = (values - values.mean(axis=1, keepdims=True)) / np.where(spread > 0, spread, 1)
        times = found.start + (np.array([-0.5, len(standard[0]) - 0.5])) / found.rate
        extent = (*times, 0, len(standard))
        shown = axes.imshow(
            values if name == "phones" else standard, aspect="auto", origin="lower", extent=extent,
            cmap="Greys" if name == "phones" else "RdBu_r", interpolation="nearest",
            vmin=0 if name == "phones" else -REACH, vmax=1 if name == "phones" else REACH,
        )  # fmt: skip
        axes.set_ylabel(f"{name}\nfeature")
        if name != "phones":
            figure.colorbar(shown, ax=axes, label="deviations", pad=0.01)
    top = every[0].twiny()
    middles = (track.bounds[:-1] + track.bounds[1:]) / 2
    top.set_xlim(every[0].get_xlim())
    top.set_xticks(middles, [INVENTORY.phones[code] for code in track.codes], fontsize=6)
    every[-1].set_xlabel("seconds")


@click.command(help=__doc__)
@click.argument("alignment", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), required=True)
def main(alignment: Path, output: Path) -> None:
    """Encode the line and draw it."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    audio, track = find_audio(alignment), to_phones(read_alignment(alignment), "english")[0]
    if audio is None:
        raise click.UsageError(f"{alignment} has no recording beside it")
    features = {"phones": track_features(track)}
    for name in ENCODERS:
        try:
            features[name] = encode(load_encoder(name), read_sound(audio))
        except PhonanimError as error:
            click.echo(f"without {name}: {error}", err=True)
    figure = Figure(figsize=(9, 1.2 + 1.7 * len(features)), layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure, features, track)
    with atomic_path(output) as unfinished:
        figure.savefig(unfinished, dpi=DOTS, format="png", metadata={"Software": None})


if __name__ == "__main__":
    main()
