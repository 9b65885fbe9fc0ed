"""FaceDiffuser, made anew: what its parts bring, what its seeds change, and what sampling costs.

    python benchmarks/facediffuser.py run benchmarks/facediffuser.toml --json work/facediffuser.json
    python benchmarks/facediffuser.py steps models/facediffuser --json work/facediffuser.json
    python benchmarks/facediffuser.py speed models/facediffuser --json work/facediffuser.json
    python benchmarks/facediffuser.py table benchmarks/facediffuser.toml work/facediffuser.json

A reimplementation from the thesis, trained on some hundred sentences of one speaker: what it reaches here
says nothing of the author's own system. All is measured on clips of the training split that no model of
this page learned from. `run` goes on where it was cut off.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray
from takes import MEASURES, Judge, measure_mouth

from phonanim import regressors
from phonanim.core.threads import use_one_thread
from phonanim.corpus.corpus import load_corpus
from phonanim.encoders import encode
from phonanim.media.audio import Sound, read_sound
from phonanim.regressors import make_config
from phonanim.regressors._denoiser import extend_steps
from phonanim.regressors._diffusion import add_noise, guided_motion, sampling_times, signal_share
from phonanim.regressors._steps import cached_encoder, features_at_steps, step_times
from phonanim.regressors.facediffuser import FaceDiffuser

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parent.parent
SEED = 1
SECONDS = "seconds.txt"  # in a journal
Floats = NDArray[np.float32]


@click.group(help=__doc__)
def main() -> None:
    use_one_thread()


@main.command()
@click.argument("config", type=click.Path(exists=True, path_type=Path))
@click.option("--corpus", "folder", default=ROOT / "work/corpus", type=click.Path(path_type=Path))
@click.option("--data", default=ROOT.parent / "shared/data/grid_s1", type=click.Path(path_type=Path))
@click.option("--work", default=ROOT / "work/diffusers", type=click.Path(path_type=Path))
@click.option("--json", "output", required=True, type=click.Path(path_type=Path))
@click.option("--only", help="Names of variants, separated by commas.")
def run(config: Path, folder: Path, data: Path, work: Path, output: Path, only: str | None) -> None:
    """Train and measure every variant that the JSON file does not have yet."""
    table = tomllib.loads(config.read_text("utf-8"))
    judge = Judge.of(folder, data)
    for name, changes in table["variants"].items():
        values = {"targets": "mouth", "sampled": [], **table["base"], **changes}
        targets, counts = values.pop("targets"), values.pop("sampled")
        known = read_rows(output).get("variants", {})
        missing = [count for count in (None, *counts) if title(name, count) not in known]
        if not missing or (only and name not in only.split(",")):
            continue
        journal = work / name.replace(" ", "_")
        model = learn(judge, make_config("facediffuser", values, name), targets, journal)
        facts = {"targets": targets, "parameters": size_of(model), "training_s": seconds_of(journal)}
        for count in missing:
            row = MEASURES[targets](judge, model.with_settings(steps=count) if count else model)
            add_row(output, "variants", title(name, count), row | facts)


def title(name: str, count: int | None) -> str:
    """The name of a row: a variant, or one that is sampled in another number of steps."""
    return f"{name}, {count} steps" if count else name


def learn(judge: Judge, settings: Any, targets: str, journal: Path) -> FaceDiffuser:
    """Train a variant; one whose training has ended is read from its journal, which keeps its seconds."""
    learned, held_out = (judge.examples(clips, targets) for clips in (judge.learned, judge.held_out))
    spent, begin, calls = seconds_of(journal), time.process_time(), list[float]()

    def keep(done: float) -> None:
        calls.append(done)
        if calls[0] < 1:  # what had ended says so at once, and takes no more
            (journal / SECONDS).write_text(f"{spent + time.process_time() - begin}\n", encoding="utf-8")

    return FaceDiffuser.fit(settings, learned, held_out, np.random.default_rng(SEED), keep, journal)


def seconds_of(journal: Path) -> float:
    """Processor seconds that the training of a journal took, halts left out."""
    return float((journal / SECONDS).read_text("utf-8")) if (journal / SECONDS).exists() else 0.0


def size_of(model: FaceDiffuser) -> int:
    """Numbers that were learned."""
    return sum(tensor.size for tensor in model.weights.values())


def read_rows(output: Path) -> dict[str, Any]:
    """What has been measured so far."""
    return dict(json.loads(output.read_text("utf-8"))) if output.exists() else {}


def add_row(output: Path, table: str, name: str, row: dict[str, Any]) -> None:
    """Keep a row, and show it."""
    rows = read_rows(output)
    rows.setdefault(table, {})[name] = row
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    shown = {key: round(value, 4) if isinstance(value, float) else value for key, value in row.items()}
    print(f"{name:<24}", shown, flush=True)


@main.command()
@click.argument("folder", type=click.Path(exists=True, path_type=Path))
@click.option("--corpus", default=ROOT / "work/corpus", type=click.Path(path_type=Path))
@click.option("--json", "output", required=True, type=click.Path(path_type=Path))
@click.option("--count", "counts", multiple=True, type=int, default=(1, 2, 5, 10, 25, 50, 100, 250, 500))
def steps(folder: Path, corpus: Path, output: Path, counts: tuple[int, ...]) -> None:
    """Measure a model of a recipe that is sampled in more and fewer steps, on the recipe's held-out clips."""
    model = trained(folder)
    judge = Judge.of(corpus, ROOT, json.loads((folder / "model.json").read_text())["provenance"]["seed"])
    for count in counts:
        if count <= model.config.timesteps:
            before = time.process_time()
            row = measure_mouth(judge, model.with_settings(steps=count))
            add_row(output, "steps", str(count), row | {"measured_s": time.process_time() - before})


def trained(folder: Path) -> FaceDiffuser:
    """The regressor of a model folder."""
    found = regressors.load(folder).regressor
    if not isinstance(found, FaceDiffuser):
        raise click.ClickException(f"{folder}: is not a model of kind facediffuser")
    return found


@main.command()
@click.argument("folder", type=click.Path(exists=True, path_type=Path))
@click.option("--corpus", "corpus_folder", default=ROOT / "work/corpus", type=click.Path(path_type=Path))
@click.option("--json", "output", required=True, type=click.Path(path_type=Path))
@click.option("--count", default=50, help="Steps of sampling.")
@click.option("--seconds", default=4.0, help="How much speech.")
def speed(folder: Path, corpus_folder: Path, output: Path, count: int, seconds: float) -> None:
    """Time sampling with the encoder of the sound outside the loop, and inside it at every step."""
    os.environ["PHONANIM_CACHE"] = ""  # nothing is kept, everything is encoded anew
    corpus = load_corpus(corpus_folder)
    parts = [read_sound(corpus.audio[int(clip)]) for clip in corpus.clips_of("train")[:2]]
    samples = np.concatenate([part.samples for part in parts])[: round(seconds * parts[0].rate)]
    sound, model = Sound(samples, parts[0].rate), trained(folder).with_settings(steps=count)
    grid = step_times(sound.duration, model.config.rate)
    encoder = cached_encoder(model.config.encoder)
    _, encoding = timed(lambda: encode(encoder, sound))
    outside, once = timed(lambda: model.modes_at_steps(encode(encoder, sound), grid))
    inside, every = timed(lambda: every_step_recognized(model, sound))
    row = {
        "seconds": seconds,
        "steps": count,
        "encoder_s": encoding,
        "outside_s": once,
        "inside_s": every,
        "times_slower": every / once,
        "same_output": bool(np.array_equal(outside, inside)),
    }
    add_row(output, "speed", f"{count} steps", row)


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """A result and the processor seconds that it took."""
    before = time.process_time()
    return work(), time.process_time() - before


def every_step_recognized(model: FaceDiffuser, sound: Sound) -> Floats:
    """Sampling as in the released code of the author: the encoder runs at every step."""
    config = model.config
    asked = step_times(sound.duration, config.rate)
    grid, shares, found = (
        extend_steps(asked, config.rate),
        signal_share(config.timesteps),
        np.empty(0, np.float32),
    )
    for turn, at in enumerate(sampling_times(config.timesteps, config.steps)):
        values = features_at_steps(encode(cached_encoder(config.encoder), sound), grid, config.rate)
        audio = model.embed_sound(model.normalize_features(values)[None])
        noise = model.noise(turn, 0, len(grid))
        noisy = add_noise(found, shares[at], noise) if turn else noise
        found = guided_motion(config, model.weights, noisy, int(at), audio, None)
    return model.unscale_modes(found)[0, : len(asked)]


@main.command()
@click.argument("config", type=click.Path(exists=True, path_type=Path))
@click.argument("results", type=click.Path(exists=True, path_type=Path))
def table(config: Path, results: Path) -> None:
    """Print the tables of the rows at hand, as Markdown."""
    rows = read_rows(results)
    known = rows.get("variants", {})
    for heading, names in tomllib.loads(config.read_text("utf-8"))["tables"].items():
        show(heading, "variant", {name: known[name] for name in names if name in known})
    show("steps", "steps", rows.get("steps", {}))
    show("speed", "sampling", rows.get("speed", {}))


COLUMNS = {
    "vertex_error_mm": ("vertex error, mm", 3),
    "interval": ("95 % interval", 0),
    "aperture_r": ("aperture r", 3),
    "width_r": ("width r", 3),
    "mce": ("MCE, %", 2),
    "lce": ("LCE, %", 2),
    "jaw_r": ("jawOpen r", 3),
    "c_fdd": ("C-FDD, %", 3),
    "diversity_lips_mm": ("diversity, lips, mm", 3),
    "diversity_lips": ("diversity, lips, %", 2),
    "diversity_lips_share": ("of their motion", 2),
    "diversity_cheeks_mm": ("cheeks, mm", 3),
    "diversity_cheeks_share": ("of their motion", 2),
    "diversity_jaw_mm": ("jaw, mm", 3),
    "diversity_jaw_share": ("of its motion", 2),
    "diversity_upper_mm": ("upper face, mm", 3),
    "diversity_upper": ("upper face, %", 2),
    "diversity_upper_share": ("of its motion", 2),
    "fdd_offset_mm": ("FDD (offset), mm", 3),
    "fdd_step_mm": ("FDD (step), mm", 4),
    "encoder_s": ("encoder alone, s", 2),
    "outside_s": ("encoder outside the loop, s", 2),
    "inside_s": ("inside, s", 2),
    "times_slower": ("times slower", 1),
    "same_output": ("same output", 0),
    "parameters": ("parameters", 0),
    "training_s": ("training, processor s", 0),
}


def show(heading: str, first: str, rows: dict[str, dict[str, Any]]) -> None:
    """Print one table; columns that no row has are left out."""
    columns = [key for key in COLUMNS if any(key in row for row in rows.values())]
    if not rows:
        return
    print(f"\n### {heading}\n\n| {first} | " + " | ".join(COLUMNS[key][0] for key in columns) + " |")
    print("|---|" + "---:|" * len(columns))
    for name, row in rows.items():
        print(f"| {name} | " + " | ".join(cell(row.get(key), COLUMNS[key][1]) for key in columns) + " |")


def cell(value: Any, digits: int) -> str:
    """A number as a table shows it."""
    if value is None:
        return ""
    return (
        f"{value:,.{digits}f}"
        if isinstance(value, float)
        else f"{value:,}"
        if type(value) is int
        else str(value)
    )


if __name__ == "__main__":
    main()
