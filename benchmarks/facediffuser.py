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
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from phonanim import regressors
from phonanim.audio import Sound, read_sound
from phonanim.corpus import Corpus, load_corpus
from phonanim.encoders import encode
from phonanim.face import FaceModel, fit_face, lip_aperture, lip_width
from phonanim.masks import landmark_masks
from phonanim.metrics import correlation, diversity, dynamics_deviation, vertex_error
from phonanim.regressors import Examples, make_config
from phonanim.regressors._diffusion import diffused, guided, kept, sample, strided
from phonanim.regressors._heard import at_steps, between, cached_encoder, listen, step_times
from phonanim.regressors.facediffuser import FaceDiffuser
from phonanim.statistics import bootstrap_interval, mean_rows
from phonanim.threads import one_thread
from phonanim.training import examples

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parent.parent
SEED = 1
TAKES = 5  # seeds that are compared
VARIANCE = 0.99  # of the whole face that its modes keep
LIPS = ("mouth", "jaw")  # how the names of controls begin that speech moves
UPPER = ("brow", "eye")
Floats = NDArray[np.float32]
Clips = NDArray[np.int64]


@click.group(help=__doc__)
def main() -> None:
    one_thread()


@dataclass(frozen=True)
class Judge:
    """The corpus, the clips that are learned from and those that are measured, and what may be predicted."""

    corpus: Corpus
    data: Path
    learned: Clips
    held_out: Clips

    @classmethod
    def of(cls, folder: Path, data: Path) -> Judge:
        """The split of benchmarks/audio.py."""
        corpus = load_corpus(folder)
        shuffled = np.random.default_rng(0).permutation(corpus.clips_of("train"))
        return cls(corpus, data, np.sort(shuffled[89:]), np.sort(shuffled[:89]))

    @cached_property
    def mouth(self) -> FaceModel:
        """The face of every regressor: what lies below the nose."""
        return fit_face(self.captured(self.corpus.clips_of("train")), self.corpus.indices)

    @cached_property
    def face(self) -> FaceModel:
        """Modes of all landmarks, so that lids, brows and cheeks take part."""
        return whole_face(self.captured(self.corpus.clips_of("train")), self.corpus.indices)

    @cached_property
    def scores(self) -> tuple[list[str], Floats]:
        """The names of ARKit's controls, and what the tracker gave each of them in every frame, 0 to 1."""
        with np.load(self.data / "blendshapes52.npz") as stored:
            if stored["clips"].tolist() != list(self.corpus.clips):
                raise click.ClickException(f"{self.data}: its clips are not those of the corpus")
            return stored["names"].tolist(), (stored["scores"] * stored["scale"]).astype(np.float32)

    def captured(self, clips: Clips) -> Floats:
        """Landmarks of clips end to end, (frames, landmarks, 3)."""
        return self.corpus.landmarks[self.corpus.rows(clips)]

    def examples(self, clips: Clips, targets: str) -> Examples:
        """Clips with their sound; targets are modes of the mouth or of the face, or controls of a rig."""
        if targets != "rig":
            return examples(self.corpus, getattr(self, targets), clips, heard=True)
        found = examples(self.corpus, self.mouth, clips, heard=True)
        return replace(found, targets=tuple(self.scores[1][self.corpus.rows([clip])] for clip in clips))


def whole_face(shapes: Floats, indices: NDArray[np.int64]) -> FaceModel:
    """Shape PCA of all landmarks, (frames, landmarks, 3) mm."""
    mean = shapes.mean(axis=0, dtype=np.float64)
    centred = (shapes - mean).reshape(len(shapes), -1)
    energy, vectors = np.linalg.eigh(centred.T @ centred / len(centred))
    energy, vectors = energy[::-1], vectors[:, ::-1].T
    count = int(np.searchsorted(np.cumsum(energy) / energy.sum(), VARIANCE)) + 1
    return FaceModel(mean, vectors[:count].reshape(count, *mean.shape), np.sqrt(energy[:count]), indices)


@main.command()
@click.argument("config", type=click.Path(exists=True, path_type=Path))
@click.option("--corpus", "folder", default=ROOT / "work/corpus", type=click.Path(path_type=Path))
@click.option("--data", default=ROOT.parent / "shared/data/grid_s1", type=click.Path(path_type=Path))
@click.option("--work", default=ROOT / "work/facediffuser", type=click.Path(path_type=Path))
@click.option("--json", "output", required=True, type=click.Path(path_type=Path))
@click.option("--only", help="Names of variants, separated by commas.")
def run(config: Path, folder: Path, data: Path, work: Path, output: Path, only: str | None) -> None:
    """Train and measure every variant that the JSON file does not have yet."""
    table = tomllib.loads(config.read_text("utf-8"))
    judge = Judge.of(folder, data)
    for name, changes in table["variants"].items():
        if name in read_rows(output).get("variants", {}) or (only and name not in only.split(",")):
            continue
        values = {**table["base"], **changes}
        targets = values.pop("targets", "mouth")
        settings = make_config("facediffuser", values, name)
        before, epochs = time.process_time(), []
        model = FaceDiffuser.fit(
            settings,
            judge.examples(judge.learned, targets),
            judge.examples(judge.held_out, targets),
            np.random.default_rng(SEED),
            epochs.append,
            work / name.replace(" ", "_"),
        )
        spent = time.process_time() - before
        measured = MEASURES[targets](judge, model)
        facts = {"training_s": spent, "epochs": len(epochs) - 1, "parameters": size_of(model)}
        add_row(output, "variants", name, {"targets": targets} | measured | facts)


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


def takes_of(judge: Judge, model: FaceDiffuser, seeds: range) -> NDArray[np.floating]:
    """Held-out clips as a model speaks them, side by side: (takes, clips, frames, modes)."""
    sounds = [read_sound(judge.corpus.audio[clip]) for clip in judge.held_out]
    grid = step_times(min(sound.duration for sound in sounds), model.config.rate)
    encoder = cached_encoder(model.config.encoder)
    values = [at_steps(listen(encoder, sound, None), grid, model.config.rate) for sound in sounds]
    heard = model.embedded(np.stack([model.normal(one) for one in values]))
    wide = (len(sounds), len(grid), len(model.low))
    place = (judge.corpus.times(int(judge.held_out[0])) - grid[0]) * model.config.rate

    def take(seed: int) -> NDArray[np.floating]:
        def noise(turn: int) -> Floats:
            return np.random.default_rng([seed, turn]).standard_normal(wide, np.float32)

        found = model.unscaled(sample(model.config, model.weights, heard, noise))
        return np.stack([between(one, place) for one in found])

    return np.stack([take(seed) for seed in seeds])


def measure_mouth(judge: Judge, model: FaceDiffuser) -> dict[str, Any]:
    """Errors of the lower face, and how far takes differ."""
    takes = takes_of(judge, model, range(TAKES if model.config.diffusion else 1))
    return lips(judge, judge.mouth, takes) | spread(judge, judge.mouth, takes)


def measure_face(judge: Judge, model: FaceDiffuser) -> dict[str, Any]:
    """The same of the whole face, and how lively its upper part is."""
    takes = takes_of(judge, model, range(TAKES if model.config.diffusion else 1))
    return lips(judge, judge.face, takes) | spread(judge, judge.face, takes) | lively(judge, takes)


def lips(judge: Judge, face: FaceModel, takes: NDArray[np.floating]) -> dict[str, Any]:
    """Error of the first take over the landmarks below the nose, and correlations of the lips."""
    frames = takes.shape[2]
    shapes = face.instance(takes[0].reshape(-1, takes.shape[3]))
    known = judge.captured(judge.held_out)
    errors = vertex_error(shapes, known, judge.mouth).reshape(-1, frames).mean(axis=1)
    low, high = bootstrap_interval(mean_rows(errors), np.random.default_rng(0))
    return {
        "vertex_error_mm": float(errors.mean()),
        "interval": f"{low:.3f} to {high:.3f}",
        "aperture_r": correlation(lip_aperture(shapes, face), lip_aperture(known, face)),
        "width_r": correlation(lip_width(shapes, face), lip_width(known, face)),
    }


def spread(judge: Judge, face: FaceModel, takes: NDArray[np.floating]) -> dict[str, Any]:
    """Diversity of takes by region in mm, and as a share of how far the captured region is from its mean."""
    if len(takes) < 2:
        return {}
    shapes = np.stack([face.instance(one.reshape(-1, one.shape[-1])) for one in takes])
    known, found = judge.captured(judge.held_out), {}
    for region in ("lips", "upper") if face is judge.face else ("lips", "cheeks", "jaw"):
        rows = landmark_masks(face)[region]
        rows = rows[face.moving[rows]]
        far = np.linalg.norm(known[:, rows] - face.mean[rows], axis=2).mean()
        found[f"diversity_{region}_mm"] = diversity(shapes, rows)
        found[f"diversity_{region}_share"] = found[f"diversity_{region}_mm"] / float(far)
    return found


def lively(judge: Judge, takes: NDArray[np.floating]) -> dict[str, Any]:
    """FDD of the upper face (equation 6), 0 for motion as lively as the captured; the mean over clips."""
    face, frames = judge.face, takes.shape[2]
    known = judge.captured(judge.held_out).reshape(-1, frames, len(face.mean), 3)
    upper = landmark_masks(face)["upper"]
    return {
        f"fdd_{motion}_mm": float(
            np.mean(
                [
                    dynamics_deviation(face.instance(one), clip, face.mean, upper, motion)
                    for one, clip in zip(takes[0], known, strict=True)
                ]
            )
        )
        for motion in ("offset", "step")
    }


def measure_rig(judge: Judge, model: FaceDiffuser) -> dict[str, Any]:
    """Errors of ARKit's controls in hundredths of their range: all of them, and those of lips and jaw."""
    takes = takes_of(judge, model, range(TAKES if model.config.diffusion else 1))
    names, scores = judge.scores
    known = scores[judge.corpus.rows(judge.held_out)].reshape(takes.shape[1:])
    apart = 100 * np.abs(takes[0] - known)
    regions = {"lips": starting(names, LIPS), "upper": starting(names, UPPER)}
    jaw = names.index("jawOpen")
    found = {
        "mce": float(apart.mean()),
        "lce": float(apart[..., regions["lips"]].mean()),
        "jaw_r": correlation(takes[0][..., jaw].ravel(), known[..., jaw].ravel()),
        "c_fdd": 100 * float((steps_of(known) - steps_of(takes[0]))[:, regions["upper"]].mean()),
    }
    pairs = np.triu_indices(len(takes), k=1)
    for region, columns in regions.items() if len(takes) > 1 else ():
        part = takes[..., columns]
        found[f"diversity_{region}"] = 100 * float(np.abs(part[pairs[0]] - part[pairs[1]]).mean())
        far = 100 * np.abs(known[..., columns] - known[..., columns].mean(axis=(0, 1))).mean()
        found[f"diversity_{region}_share"] = found[f"diversity_{region}"] / float(far)
    return found


def steps_of(curves: NDArray[np.floating]) -> NDArray[np.floating]:
    """Deviation of the change from frame to frame, (clips, frames, controls) -> (clips, controls)."""
    return np.asarray(np.abs(np.diff(curves, axis=1)).std(axis=1))


def starting(names: list[str], heads: tuple[str, ...]) -> list[int]:
    """Columns of the controls whose names begin so."""
    return [column for column, name in enumerate(names) if name.startswith(heads)]


MEASURES: dict[str, Callable[[Judge, FaceDiffuser], dict[str, Any]]] = {
    "mouth": measure_mouth,
    "face": measure_face,
    "rig": measure_rig,
}


@main.command()
@click.argument("folder", type=click.Path(exists=True, path_type=Path))
@click.option("--corpus", default=ROOT / "work/corpus", type=click.Path(path_type=Path))
@click.option("--json", "output", required=True, type=click.Path(path_type=Path))
@click.option("--count", "counts", multiple=True, type=int, default=(1, 2, 5, 10, 25, 50, 100, 250, 500))
def steps(folder: Path, corpus: Path, output: Path, counts: tuple[int, ...]) -> None:
    """Measure a model that is sampled in more and fewer steps."""
    judge = Judge.of(corpus, ROOT)
    model = trained(folder)
    for count in counts:
        if count <= model.config.timesteps:
            before = time.process_time()
            row = measure_mouth(judge, model.changed(steps=count))
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
    os.environ["PHONANIM_CACHE"] = ""  # nothing is kept, everything is heard anew
    corpus = load_corpus(corpus_folder)
    parts = [read_sound(corpus.audio[int(clip)]) for clip in corpus.clips_of("train")[:2]]
    samples = np.concatenate([part.samples for part in parts])[: round(seconds * parts[0].rate)]
    sound, model = Sound(samples, parts[0].rate), trained(folder).changed(steps=count)
    grid = step_times(sound.duration, model.config.rate)
    encoder = cached_encoder(model.config.encoder)
    _, hearing = timed(lambda: encode(encoder, sound))
    outside, once = timed(lambda: model.sampled(encode(encoder, sound), grid))
    inside, every = timed(lambda: heard_every_step(model, sound))
    row = {
        "seconds": seconds,
        "steps": count,
        "encoder_s": hearing,
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


def heard_every_step(model: FaceDiffuser, sound: Sound) -> Floats:
    """Sampling as in the released code of the author: the encoder runs at every step."""
    config = model.config
    grid = step_times(sound.duration, config.rate)
    shares, found = kept(config.timesteps), np.empty(0, np.float32)
    for turn, at in enumerate(strided(config.timesteps, config.steps)):
        values = at_steps(encode(cached_encoder(config.encoder), sound), grid, config.rate)
        heard = model.embedded(model.normal(values)[None])
        noise = model.noise(turn, 0, len(grid))
        seen = diffused(found, shares[at], noise) if turn else noise
        found = guided(config, model.weights, seen, int(at), heard, None)
    return model.unscaled(found)[0]


@main.command()
@click.argument("config", type=click.Path(exists=True, path_type=Path))
@click.argument("results", type=click.Path(exists=True, path_type=Path))
def table(config: Path, results: Path) -> None:
    """Print the tables of the rows at hand, as Markdown."""
    rows = read_rows(results)
    for title, names in tomllib.loads(config.read_text("utf-8"))["tables"].items():
        show(title, "variant", {name: rows["variants"][name] for name in names if name in rows["variants"]})
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
    "epochs": ("epochs", 0),
    "training_s": ("training, processor s", 0),
}


def show(title: str, first: str, rows: dict[str, dict[str, Any]]) -> None:
    """Print one table; columns that no row has are left out."""
    columns = [key for key in COLUMNS if any(key in row for row in rows.values())]
    if not rows:
        return
    print(f"\n### {title}\n\n| {first} | " + " | ".join(COLUMNS[key][0] for key in columns) + " |")
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
