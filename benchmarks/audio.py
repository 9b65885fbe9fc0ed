"""Audio-driven regressors on the validation clips: encoders, losses, auxiliary tasks, decoders.

    python benchmarks/audio.py run benchmarks/audio.toml --json work/audio.json
    python benchmarks/audio.py table benchmarks/audio.toml work/audio.json
    python benchmarks/audio.py shares benchmarks/audio.toml work/audio.json -o docs/images/layer_shares.png
    python benchmarks/audio.py cost benchmarks/audio.toml
    python benchmarks/audio.py encoding examples/line.wav mfcc whisper phones
    python benchmarks/audio.py layers models/phisanet -o work/layers.png
    python benchmarks/audio.py epoch

All are reimplementations from the theses, trained on a few hundred sentences of one speaker: what they
reach here says nothing of the authors' own systems. `run` goes on where it was cut off.
"""

from __future__ import annotations

import json
import sys
import time
from itertools import product
from pathlib import Path
from typing import Any

import click
import numpy as np
from audio_tables import Row, Seeds, ablation, decoders, print_rows
from numpy.typing import NDArray

from phonanim import regressors
from phonanim.core.files import atomic_path, write_text
from phonanim.core.threads import use_one_thread
from phonanim.corpus.corpus import load_corpus
from phonanim.corpus.examples import make_examples
from phonanim.encoders import HOP, RATE, load_encoder
from phonanim.face.fit import fit_face
from phonanim.face.model import FaceModel, lip_aperture, lip_width
from phonanim.media.audio import Sound, read_sound, resample
from phonanim.metrics import correlation, vertex_error
from phonanim.regressors import make_config, regressor_class
from phonanim.regressors._audio import AudioRegressor
from phonanim.regressors._steps import step_times
from phonanim.training.recipes import predict_clip

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parent.parent


@click.group(help=__doc__)
def main() -> None:
    use_one_thread()


@main.command()
@click.argument("config", type=click.Path(exists=True, path_type=Path))
@click.option("--corpus", "folder", default=ROOT / "work/corpus", type=click.Path(path_type=Path))
@click.option(
    "--json", "output", required=True, type=click.Path(path_type=Path), help="Where the rows are kept."
)
@click.option("--only", help="Names of variants, separated by commas.")
@click.option("--seed", "seeds", multiple=True, type=int, help="Only these of the seeds; may be repeated.")
def run(config: Path, folder: Path, output: Path, only: str | None, seeds: tuple[int, ...]) -> None:
    """Train and measure every variant and seed that the JSON file does not have yet."""
    plan = tomllib.loads(config.read_text("utf-8"))
    corpus = load_corpus(folder)
    train = corpus.clips_of("train")
    face = fit_face(corpus.landmarks[corpus.rows(train)], corpus.indices)
    shuffled = np.random.default_rng(0).permutation(train)  # as benchmarks/evaluate.py splits it
    held_out, rest = np.sort(shuffled[:89]), np.sort(shuffled[89:])
    learned, checked = (make_examples(corpus, face, clips, with_sound=True) for clips in (rest, held_out))
    chosen = {n: v for n, v in variants(plan).items() if not only or n in only.split(",")}
    for seed, (name, values) in product(seeds or plan["seeds"], chosen.items()):
        if str(seed) in read_rows(output).get(key_of(values), {}):
            continue
        before, epochs = time.process_time(), []
        fit: Any = regressor_class("two_stage").fit
        settings = make_config("two_stage", values, name)
        model = fit(settings, learned, checked, np.random.default_rng(seed), epochs.append)
        spent = {"epochs": len(epochs) - 1, "training_s": time.process_time() - before}
        add_row(output, key_of(values), seed, measure(model, corpus, face, held_out) | spent)
        print(f"{seed} {name:<36} {spent['training_s']:.0f} s", flush=True)


def variants(plan: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """All settings of each variant."""
    return {name: {**plan["base"], **changes} for name, changes in plan["variants"].items()}


def key_of(values: dict[str, Any]) -> str:
    """What rows are kept by: variants of the same settings share theirs."""
    return json.dumps(values, sort_keys=True)


def read_rows(output: Path) -> dict[str, Seeds]:
    """What has been measured so far, by settings and seed."""
    return dict(json.loads(output.read_text("utf-8"))) if output.exists() else {}


def add_row(output: Path, key: str, seed: int, row: Row) -> None:
    """Keep a row."""
    rows = read_rows(output)
    rows.setdefault(key, {})[str(seed)] = row
    write_text(output, json.dumps(rows, indent=1) + "\n")


def measure(model: AudioRegressor, corpus: Any, face: FaceModel, clips: NDArray[np.int64]) -> Row:
    """Errors on clips, and what the decoder costs."""
    predicted = [face.instance(predict_clip(model, corpus, int(clip))) for clip in clips]
    captured = [corpus.landmarks[corpus.rows([clip])] for clip in clips]
    errors = [float(vertex_error(p, c, face).mean()) for p, c in zip(predicted, captured, strict=True)]
    shapes, known = np.concatenate(predicted), np.concatenate(captured)
    return {
        "errors_mm": errors,
        "aperture_r": correlation(lip_aperture(shapes, face), lip_aperture(known, face)),
        "width_r": correlation(lip_width(shapes, face), lip_width(known, face)),
        "shares": [float(share) for share in model.layer_shares],
        **cost_of(model, read_sound(corpus.audio[int(clips[0])])),
    }


def cost_of(model: AudioRegressor, sound: Sound) -> Row:
    """What the decoder costs, whatever it learned."""
    size = sum(tensor.size for tensor in model.weights.values())
    return {"parameters": size, "decoding_ms": decoding_ms(model, sound), "latency_ms": latency(model)}


def decoding_ms(model: AudioRegressor, sound: Sound) -> float:
    """Processor milliseconds that the decoder takes for a second of speech: the least of ten runs."""
    features, grid, taken = model.encode(sound), step_times(sound.duration, model.config.rate), []
    for _ in range(10):
        before = time.process_time()
        model.modes_at_steps(features, grid)
        taken.append(time.process_time() - before)
    return 1000 * min(taken) / sound.duration


def latency(model: AudioRegressor) -> str:
    """Milliseconds of sound, the step included, that must be read before it can be decoded."""
    config = model.config
    if config.decoder == "mlp":
        return f"{1000 * config.widths[1] / config.rate:.0f}"
    if config.decoder == "transformer":
        return f"{1000 * config.window / config.rate:.0f}"
    return "all of it" if config.bidirectional else f"{1000 / config.rate:.0f}"


@main.command()
@click.argument("config", type=click.Path(exists=True, path_type=Path))
@click.option("--corpus", "folder", default=ROOT / "work/corpus", type=click.Path(path_type=Path))
def cost(config: Path, folder: Path) -> None:
    """Print what the decoders cost, without training them."""
    plan = tomllib.loads(config.read_text("utf-8"))
    corpus = load_corpus(folder)
    train = corpus.clips_of("train")
    clips, face = train[:1], fit_face(corpus.landmarks[corpus.rows(train)], corpus.indices)
    some = make_examples(corpus, face, clips, with_sound=True)
    fit: Any = regressor_class("two_stage").fit
    for name in plan["decoders"]["names"]:
        settings = make_config("two_stage", {**variants(plan)[name], "epochs": 0}, name)
        model = fit(settings, some, some, np.random.default_rng(0), lambda done: None)
        row = cost_of(model, read_sound(corpus.audio[int(clips[0])]))
        print(
            f"{name:<12} {row['parameters']:>10,} {row['decoding_ms']:5.1f} ms, latency {row['latency_ms']}"
        )


@main.command()
@click.argument("config", type=click.Path(exists=True, path_type=Path))
@click.argument("results", type=click.Path(exists=True, path_type=Path))
def table(config: Path, results: Path) -> None:
    """Print the tables of the rows at hand, as Markdown."""
    plan, rows = tomllib.loads(config.read_text("utf-8")), read_rows(results)
    known = {name: rows[key_of(v)] for name, v in variants(plan).items() if key_of(v) in rows}
    for title, names in plan["tables"].items():
        if names[0] in known:
            print_rows(title, ablation([name for name in names if name in known], known))
    base = plan["decoders"]["base"]
    if base in known:
        names = [name for name in plan["decoders"]["names"] if name in known]
        print_rows("Decoders (Table 3.1)", decoders(base, names, known))


@main.command()
@click.argument("recording", type=click.Path(exists=True, path_type=Path))
@click.argument("encoders", nargs=-1)
def encoding(recording: Path, encoders: tuple[str, ...]) -> None:
    """Print what encoders cost: processor milliseconds for a second of speech, the least of five runs."""
    sound = read_sound(recording)
    samples = resample(sound.samples, sound.rate, RATE)
    samples = np.pad(samples, (0, -len(samples) % HOP))
    for name in encoders:
        encoder, taken = load_encoder(name), []
        for _ in range(5):
            before = time.process_time()
            encoder.run(samples)
            taken.append(time.process_time() - before)
        print(
            f"{name}: {1000 * min(taken) / sound.duration:.1f} ms, {encoder.layers} layers of {encoder.dims}"
        )


@main.command()
@click.argument("folder", type=click.Path(exists=True, path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="A picture of them; needs matplotlib.")
def layers(folder: Path, output: Path | None) -> None:
    """Show how much of each layer of its encoder a model uses (Medina 2023, Figures 4.14 and 4.15)."""
    model: Any = regressors.load(folder).regressor
    for number, share in enumerate(model.layer_shares):
        print(f"layer {number}: {share:.3f}")
    if output:
        draw({folder.name: model.layer_shares[None]}, model.config.encoder, output)


@main.command()
@click.argument("config", type=click.Path(exists=True, path_type=Path))
@click.argument("results", type=click.Path(exists=True, path_type=Path))
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="The picture.")
def shares(config: Path, results: Path, output: Path) -> None:
    """Draw the shares of layers of every variant that learns them, in every seed; print their means."""
    plan, rows = tomllib.loads(config.read_text("utf-8")), read_rows(results)
    found = {
        name: np.array([row["shares"] for row in rows[key_of(values)].values()])
        for name, values in variants(plan).items()
        if values["inputs"] == "all_enc" and key_of(values) in rows
    }
    for name, seeds in found.items():
        print(f"{name:<28}", *(f"{share:.3f}" for share in seeds.mean(axis=0)), f"seeds: {len(seeds)}")
    draw(found, plan["base"]["encoder"], output)


def draw(found: dict[str, NDArray[np.float64]], encoder: str, output: Path) -> None:
    """A panel for each name: bars of the means of its seeds, (seeds, layers), and a dot for each seed."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(1 + 2.2 * len(found), 3), layout="constrained")
    panels = figure.subplots(1, len(found), sharey=True, squeeze=False)[0]
    for axes, (name, seeds) in zip(panels, found.items(), strict=True):
        numbers = np.arange(seeds.shape[1])
        axes.bar(numbers, seeds.mean(axis=0), color="0.8")
        axes.plot(numbers, seeds.T, "o", color="C0", markersize=4)
        axes.axhline(1 / len(numbers), color="0.4", linewidth=1, linestyle="--")
        axes.set(xticks=numbers, xlabel=f"layer of {encoder}")
        axes.set_title(name, fontsize="small")
    panels[0].set_ylabel("share of the layer (dot: a seed; dashed: equal)", fontsize="small")
    output.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(output) as unfinished:
        figure.savefig(unfinished, dpi=110, metadata={"Software": None})


@main.command()
@click.option("--corpus", "folder", default=ROOT / "work/corpus", type=click.Path(path_type=Path))
@click.option("--clips", "count", default=32, help="How many clips are learned from once.")
def epoch(folder: Path, count: int) -> None:
    """Say what PhISANet costs at its published size, 5 layers of 1024 units each way; it is not trained."""
    corpus = load_corpus(folder)
    train = corpus.clips_of("train")
    face = fit_face(corpus.landmarks[corpus.rows(train)], corpus.indices)
    learned, checked = (
        make_examples(corpus, face, clips, with_sound=True) for clips in (train[:count], train[:1])
    )
    settings = make_config("phisanet", {"epochs": 1}, "published")
    before = time.process_time()
    fit: Any = regressor_class("phisanet").fit
    model = fit(settings, learned, checked, np.random.default_rng(0), lambda done: None)
    spent = (time.process_time() - before) * len(train) / count / 60
    size = sum(tensor.size for tensor in model.weights.values())
    print(f"{size:,} parameters, {spent:.0f} minutes of a processor for each epoch of {len(train)} clips")


if __name__ == "__main__":
    main()
