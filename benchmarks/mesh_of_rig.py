"""Learn the vertices of a head: clips as motion of its mesh, up to films, scores and heat maps.

    python benchmarks/mesh_of_rig.py RECORDINGS/grid_s1 work/mesh_of_rig
    python benchmarks/mesh_of_rig.py RECORDINGS/grid_s1 work/ict --head RECORDINGS/rigs/ict_head.npz

The rig arkit animates test clips of the recordings on the shipped head (MakeHuman's, 5,391 vertices) or on
ICT-FaceKit's (24,591), as two speakers: the second has a larger face and moves less. So the "captured"
meshes are made by the rig, not by a camera: a check of size and plumbing, which says nothing of accuracy.
Each command that is run is printed, and works in a shell.
"""

from __future__ import annotations

import json
import resource
import shlex
import time
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from phonanim.core.threads import use_one_thread

use_one_thread()

FPS = 30
TEST = 2  # of five clips
SPEAKERS = {"first": (1.0, 1.0), "second": (1.1, 0.7)}  # size of the face, and intensity of its motion
SOUND = """kind = "facediffuser"
corpus = "corpus"
validation = 0.0

[settings]
encoder = "mfcc"
rate = 30.0
window = 60
latent = 64
hidden = 64
depth = 1
timesteps = 50
steps = 10
batch = 4
learning_rate = 2e-3
epochs = {epochs}
"""
PHONES = """kind = "tree"
corpus = "corpus"
validation = 0.0

[target]
components = 20

[settings]
features = "all"
width = 1
trees = 16
leaf = 4
split = "random"
columns = 0.15
"""
PLAN = """corpus = "corpus"
reference = "sound"
folds = ["test"]

[models]
sound = "sound.toml"
phones = "phones.toml"
"""


@click.command(help=__doc__)
@click.argument("recordings", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
@click.option("--head", type=click.Path(exists=True, path_type=Path), help="ICT-FaceKit's, as .npz.")
@click.option("--clips", default=10, show_default=True, type=click.IntRange(3), help="Test clips to animate.")
@click.option(
    "--epochs", default=20, show_default=True, type=click.IntRange(1), help="Of the model of sound."
)
def main(recordings: Path, folder: Path, head: Path | None, clips: int, epochs: int) -> None:
    masks = write_data(recordings, folder, head, clips)
    (folder / "sound.toml").write_text(SOUND.format(epochs=epochs), "utf-8")
    (folder / "phones.toml").write_text(PHONES, "utf-8")
    phonanim(f"corpus build {folder} --mesh {folder}/mesh.obj -o {folder}/corpus")
    for name in ("sound", "phones"):
        phonanim(f"train {folder}/{name}.toml -o {folder}/{name}")
    line = sorted((folder / "audio").glob("second_*.wav"))[TEST]
    phonanim(f"animate {line} --model {folder}/sound --style 1 --fps {FPS} -o {folder}/sound.glb --takes 2")
    aligned = folder / "textgrid" / f"{line.stem}.TextGrid"
    phonanim(f"animate {aligned} --model {folder}/phones --style 1 --fps {FPS} -o {folder}/phones.glb")
    models = f"--model {folder}/sound --model {folder}/phones"
    scored = f"-o {folder}/scored --heat {folder}/heat.png {masks}"
    phonanim(f"corpus score {folder}/corpus {models} {scored}")
    rest = f"--template {folder}/templates/second.npy --unit mm --fps {FPS}"
    clip = f"{line.stem}.npy"
    against = f"{folder}/scored/phones/{clip} --reference {folder}/scored/captured/{clip}"
    phonanim(f"evaluate {against} {rest} {masks} --alignment {aligned}")
    (folder / "plan.toml").write_text(PLAN, "utf-8")
    phonanim(f"compare {folder}/plan.toml -o {folder}/compared")
    print(f"peak of memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB")


def phonanim(command: str) -> None:
    """Run a command of phonanim, and print it with its processor time."""
    from phonanim.__main__ import run

    started = time.process_time()
    print(f"$ phonanim {command}", flush=True)
    if run(shlex.split(command)):
        raise SystemExit(2)
    print(f"  {time.process_time() - started:.0f} s", flush=True)


def write_data(recordings: Path, folder: Path, path: Path | None, clips: int) -> str:
    """Write an imported data set of two speakers, and its mesh; returns the options of its masks."""
    from phonanim import animate
    from phonanim.core.lexicon import LEXICON
    from phonanim.core.tables import read_rows
    from phonanim.corpus.importing import COLUMNS, write_wav
    from phonanim.media.audio import read_sound
    from phonanim.rig.head import load_head

    if path:
        from transfer import read_ict

    head, scale = (read_ict(path), 10.0) if path else (load_head(), 1000.0)  # to millimetres
    for part in ("motion", "audio", "textgrid", "templates"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    rows = read_rows(recordings / "clips.csv")
    chosen = sorted(row[0] for row in rows[1:] if row[rows[0].index("split")] == "test")[:clips]
    table = [",".join(COLUMNS)]
    for speaker, (size, intensity) in SPEAKERS.items():
        rest = head.vertices * scale * size
        np.save(folder / "templates" / f"{speaker}.npy", rest)
        for number, clip in enumerate(chosen):
            name, split = f"{speaker}_{clip}", "test" if number % 5 == TEST else "train"
            grid = recordings / "textgrid" / f"{clip}.TextGrid"
            take = animate(grid, rig="arkit", fps=FPS, intensity=intensity, life=0)
            points = head.shape(head.weights(take.values, take.channels)) * scale * size
            np.save(folder / "motion" / f"{name}.npy", points.astype(np.float32))
            (folder / "textgrid" / f"{name}.TextGrid").write_bytes(grid.read_bytes())
            write_wav(folder / "audio" / f"{name}.wav", read_sound(recordings / "audio" / f"{clip}.flac"))
            table.append(f"{name},{speaker},{split},{len(points)},{FPS},{len(points) / FPS},,")
    (folder / "recordings.csv").write_text("\n".join(table) + "\n", "utf-8")
    facts = {"name": "mesh_of_rig", "kind": "vertices", "names": [], "unit": "mm", "fps": FPS}
    (folder / "dataset.json").write_text(json.dumps(facts), "utf-8")
    write_obj(folder / "mesh.obj", head.vertices * scale, head.triangles)
    return "" if path else f"--mask {LEXICON}/masks/head.json"


def write_obj(path: Path, points: NDArray[np.float64], triangles: NDArray[np.int64]) -> None:
    """Write a mesh as OBJ."""
    rows = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points.tolist()]
    rows += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    path.write_text("\n".join(rows) + "\n", "utf-8")


if __name__ == "__main__":
    main()
