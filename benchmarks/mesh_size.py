"""Train on meshes of the size of VOCASET, made up, and say how much memory and time it takes.

    python benchmarks/mesh_size.py work/mesh_size --json work/mesh_size.json
    python benchmarks/mesh_size.py work/small --clips 24 --epochs 1

The meshes are slow waves with noise: a check of size and plumbing, which says nothing of speech. The folder
gets an imported data set (3.1 GB), its corpus and the model, and may be removed after.
"""

from __future__ import annotations

import json
import resource
import time
from pathlib import Path

import click
import numpy as np

from phonanim.core.threads import use_one_thread

VERTICES, FPS, RATE, SPEAKERS = 5023, 30, 16000, 12
RECIPE = """kind = "facediffuser"
corpus = "corpus"
seed = 1
validation = 0.05

[target]
components = {components}

[settings]
encoder = "mfcc"
rate = 30.0
window = 30
latent = {size}
hidden = {size}
epochs = {epochs}
steps = {steps}
"""


@click.command(help=__doc__)
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
@click.option("--clips", default=480, show_default=True, type=click.IntRange(12))
@click.option("--seconds", default=3.6, show_default=True, help="Of each clip.")
@click.option("--epochs", default=1, show_default=True)
@click.option("--components", default=0, show_default=True, help="Principal components; 0 learns all.")
@click.option("--size", default=512, show_default=True, help="Of the layers: latent and hidden.")
@click.option("--steps", default=500, show_default=True, help="Of the sampling of a line.")
@click.option("--json", "output", type=click.Path(path_type=Path))
def main(
    folder: Path,
    clips: int,
    seconds: float,
    epochs: int,
    components: int,
    size: int,
    steps: int,
    output: Path | None,
) -> None:
    use_one_thread()
    from phonanim.corpus.motion_build import build_motion_corpus
    from phonanim.training.recipes import train

    facts: dict[str, float | int] = {
        "clips": clips,
        "seconds": round(clips * seconds, 1),
        "vertices": VERTICES,
    }
    facts["size"] = size
    facts["frames_gb"] = round(clips * seconds * FPS * VERTICES * 12 / 1e9, 2)
    if not (folder / "dataset.json").is_file():
        timed("made", facts, lambda: write_data(folder, clips, seconds))
    timed("built", facts, lambda: build_motion_corpus(folder, folder / "corpus"))
    recipe = folder / "recipe.toml"
    recipe.write_text(RECIPE.format(components=components, epochs=epochs, steps=steps, size=size), "utf-8")
    timed("trained", facts, lambda: train(recipe, folder / "model"))
    timed("sampled", facts, lambda: sample(folder))
    text = json.dumps(facts, indent=1)
    print(text)
    if output:
        output.write_text(text + "\n", "utf-8")


def timed(name: str, facts: dict[str, float | int], work: object) -> None:
    """Do a part, and add its processor seconds and the peak of memory so far."""
    before = time.process_time()
    work()  # type: ignore[operator]
    facts[f"{name}_s"] = round(time.process_time() - before, 1)
    facts[f"{name}_peak_gb"] = round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6, 2)
    print(name, facts[f"{name}_s"], "s, peak", facts[f"{name}_peak_gb"], "GB", flush=True)


def write_data(folder: Path, clips: int, seconds: float) -> None:
    """An imported data set of made-up meshes: slow waves over a ball, and sound that follows them."""
    from phonanim.corpus.importing import COLUMNS, write_wav
    from phonanim.media.audio import Sound

    rng = np.random.default_rng(1)
    ball = rng.standard_normal((VERTICES, 3))
    ball *= 100 / np.linalg.norm(ball, axis=1, keepdims=True)
    ways = rng.standard_normal((4, VERTICES, 3)).astype(np.float32)
    for part in ("motion", "audio"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    rows = [",".join(COLUMNS)]
    count = round(seconds * FPS)
    for number in range(clips):
        speaker = f"speaker{number % SPEAKERS:02d}"
        name, split = f"{speaker}_{number:03d}", "test" if number % SPEAKERS == SPEAKERS - 1 else "train"
        waves = np.sin(np.arange(count)[:, None] / rng.uniform(2, 12, 4)).astype(np.float32)
        points = ball.astype(np.float32) + np.tensordot(waves, ways, 1)
        points += rng.standard_normal(points.shape, np.float32) * np.float32(0.05)
        np.save(folder / "motion" / f"{name}.npy", points)
        tone = np.sin(2 * np.pi * 150 * np.arange(round(seconds * RATE)) / RATE)
        loud = np.interp(np.arange(len(tone)) / RATE, np.arange(count) / FPS, 0.5 + 0.4 * waves[:, 0])
        write_wav(folder / "audio" / f"{name}.wav", Sound((tone * loud).astype(np.float32), RATE))
        rows.append(f"{name},{speaker},{split},{count},{FPS},{seconds},,")
    (folder / "recordings.csv").write_text("\n".join(rows) + "\n", "utf-8")
    facts = {"name": "made_up", "kind": "vertices", "names": [], "unit": "mm", "fps": FPS}
    (folder / "dataset.json").write_text(json.dumps(facts), "utf-8")


def sample(folder: Path) -> None:
    """Predict one clip, and check its size."""
    from phonanim.corpus.motion import load_motion_corpus
    from phonanim.evaluation.corpora import predict_frames
    from phonanim.pipeline import load_model

    corpus = load_motion_corpus(folder / "corpus")
    clip = int(corpus.clips_of("test")[0])
    found = predict_frames(load_model(str(folder / "model")), corpus, clip)
    assert found.shape == corpus.frames(clip).shape


if __name__ == "__main__":
    main()
