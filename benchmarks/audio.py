"""Audio-driven regressors on the validation clips: encoders, losses, auxiliary tasks, decoders.

    python benchmarks/audio.py run benchmarks/audio.toml --json work/audio.json
    python benchmarks/audio.py table benchmarks/audio.toml work/audio.json
    python benchmarks/audio.py encoding examples/line.wav mfcc whisper phones
    python benchmarks/audio.py layers models/phisanet -o work/layers.png

All are reimplementations from the theses, trained on a few hundred sentences of one speaker: what they
reach here says nothing of the authors' own systems. `run` goes on where it was cut off.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import click
import numpy as np

from phonanim import regressors
from phonanim.audio import Sound, read_sound, resample
from phonanim.corpus import load_corpus
from phonanim.encoders import HOP, RATE, load_encoder
from phonanim.face import FaceModel, fit_face, lip_aperture, lip_width
from phonanim.metrics import correlation, vertex_error
from phonanim.regressors import make_config, regressor_class
from phonanim.regressors._heard import Heard, step_times
from phonanim.statistics import bootstrap_interval, mean_rows
from phonanim.threads import one_thread
from phonanim.training import examples, predict_clip

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parent.parent
SEED = 1
COLUMNS = {
    "vertex_error_mm": "vertex error, mm",
    "interval": "95 % interval",
    "aperture_r": "aperture r",
    "width_r": "width r",
    "parameters": "parameters",
    "decoding_ms": "decoding, ms a second of speech",
    "latency_ms": "latency of the decoder, ms",
    "epochs": "epochs",
    "training_s": "training, processor s",
}
DIGITS = {"vertex_error_mm": 3, "aperture_r": 3, "width_r": 3, "decoding_ms": 1, "training_s": 0}


@click.group(help=__doc__)
def main() -> None:
    one_thread()


@main.command()
@click.argument("config", type=click.Path(exists=True, path_type=Path))
@click.option("--corpus", "folder", default=ROOT / "work/corpus", type=click.Path(path_type=Path))
@click.option(
    "--json", "output", required=True, type=click.Path(path_type=Path), help="Where the rows are kept."
)
@click.option("--only", help="Names of variants, separated by commas.")
def run(config: Path, folder: Path, output: Path, only: str | None) -> None:
    """Train and measure every variant that the JSON file does not have yet."""
    table = tomllib.loads(config.read_text("utf-8"))
    corpus = load_corpus(folder)
    train = corpus.clips_of("train")
    face = fit_face(corpus.landmarks[corpus.rows(train)], corpus.indices)
    shuffled = np.random.default_rng(0).permutation(train)  # as benchmarks/evaluate.py splits it
    held_out, rest = np.sort(shuffled[:89]), np.sort(shuffled[89:])
    learned, checked = (examples(corpus, face, clips, heard=True) for clips in (rest, held_out))
    rows = json.loads(output.read_text()) if output.exists() else {}
    for name, changes in table["variants"].items():
        if name in rows or (only and name not in only.split(",")):
            continue
        settings = make_config("two_stage", {**table["base"], **changes}, name)
        before, epochs = time.process_time(), []
        fit: Any = regressor_class("two_stage").fit
        model = fit(settings, learned, checked, np.random.default_rng(SEED), epochs.append)
        spent = time.process_time() - before
        measured = measure(model, corpus, face, held_out)
        rows[name] = measured | {"epochs": len(epochs) - 1, "training_s": spent, "settings": changes}
        output.write_text(json.dumps(rows, indent=1) + "\n")
        print(
            f"{name:<36}",
            {key: rows[name][key] for key in ("vertex_error_mm", "aperture_r", "training_s")},
            flush=True,
        )


def measure(model: Heard, corpus: Any, face: FaceModel, clips: np.ndarray) -> dict[str, Any]:
    """Errors on clips, and what the decoder costs."""
    predicted = [face.instance(predict_clip(model, corpus, int(clip))) for clip in clips]
    captured = [corpus.landmarks[corpus.rows([clip])] for clip in clips]
    errors = np.array([vertex_error(p, c, face).mean() for p, c in zip(predicted, captured, strict=True)])
    shapes, known = np.concatenate(predicted), np.concatenate(captured)
    low, high = bootstrap_interval(mean_rows(errors), np.random.default_rng(0))
    return {
        "vertex_error_mm": float(errors.mean()),
        "interval": f"{low:.3f} to {high:.3f}",
        "aperture_r": correlation(lip_aperture(shapes, face), lip_aperture(known, face)),
        "width_r": correlation(lip_width(shapes, face), lip_width(known, face)),
        "parameters": sum(tensor.size for tensor in model.weights.values()),
        "decoding_ms": decoding_ms(model, read_sound(corpus.audio[int(clips[0])])),
        "latency_ms": latency(model),
    }


def decoding_ms(model: Heard, sound: Sound) -> float:
    """Processor milliseconds that the decoder takes for a second of speech: the least of ten runs."""
    features, grid, taken = model.hear(sound), step_times(sound.duration, model.config.rate), []
    for _ in range(10):
        before = time.process_time()
        model.decoded(features, grid)
        taken.append(time.process_time() - before)
    return 1000 * min(taken) / sound.duration


def latency(model: Heard) -> str:
    """Milliseconds of sound, the step included, that must be heard before it can be decoded."""
    config = model.config
    if config.decoder == "mlp":
        return f"{1000 * config.widths[1] / config.rate:.0f}"
    if config.decoder == "transformer":
        return f"{1000 * config.window / config.rate:.0f}"
    return "all of it" if config.bidirectional else f"{1000 / config.rate:.0f}"


@main.command()
@click.argument("config", type=click.Path(exists=True, path_type=Path))
@click.argument("results", type=click.Path(exists=True, path_type=Path))
def table(config: Path, results: Path) -> None:
    """Print the tables of the rows at hand, as Markdown."""
    rows = json.loads(results.read_text("utf-8"))
    for title, names in tomllib.loads(config.read_text("utf-8"))["tables"].items():
        print(f"\n### {title}\n\n| variant | " + " | ".join(COLUMNS.values()) + " |")
        print("|---|" + "---:|" * len(COLUMNS))
        for name in names:
            if name in rows:
                print(f"| {name} | " + " | ".join(cell(key, rows[name][key]) for key in COLUMNS) + " |")


def cell(key: str, value: Any) -> str:
    """A number as the table shows it."""
    return f"{value:.{DIGITS[key]}f}" if key in DIGITS else f"{value:,}" if isinstance(value, int) else value


@main.command()
@click.argument("recording", type=click.Path(exists=True, path_type=Path))
@click.argument("encoders", nargs=-1)
def encoding(recording: Path, encoders: tuple[str, ...]) -> None:
    """Print what encoders cost: processor milliseconds for a second of speech, the least of five runs."""
    sound = read_sound(recording)
    heard = resample(sound.samples, sound.rate, RATE)
    heard = np.pad(heard, (0, -len(heard) % HOP))
    for name in encoders:
        encoder, taken = load_encoder(name), []
        for _ in range(5):
            before = time.process_time()
            encoder.run(heard)
            taken.append(time.process_time() - before)
        print(
            f"{name}: {1000 * min(taken) / sound.duration:.1f} ms, {encoder.layers} layers of {encoder.dims}"
        )


@main.command()
@click.argument("folder", type=click.Path(exists=True, path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="A picture of them; needs matplotlib.")
def layers(folder: Path, output: Path | None) -> None:
    """Show how much of each layer of its encoder a model hears (Medina 2023, Figures 4.14 and 4.15)."""
    model = regressors.load(folder).regressor
    shares = model.shares  # type: ignore[attr-defined]
    for number, share in enumerate(shares):
        print(f"layer {number}: {share:.3f}")
    if output:
        draw(shares, str(model.config.encoder), output)


def draw(shares: np.ndarray, encoder: str, output: Path) -> None:
    """A bar for each layer."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 3), layout="constrained")
    axes = figure.add_subplot()
    axes.bar(np.arange(len(shares)), shares)
    axes.set(xlabel=f"layer of {encoder}", ylabel="share", xticks=np.arange(len(shares)))
    figure.savefig(output, dpi=150)


if __name__ == "__main__":
    main()
