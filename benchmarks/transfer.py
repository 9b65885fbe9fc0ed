"""Deformation transfer onto a head whose artist made the same shapes: how far apart the two are.

    python benchmarks/transfer.py [ict_head.npz]

The shipped head's shapes are transferred to ICT-FaceKit's bare head (MIT; 24,591 vertices) and compared with
ICT's own jaw and mouth shapes of the same names: the mean distance of the face's vertices as a fraction of
the mean motion, over the vertices that the shape moves by a tenth of its largest motion or more. "scaled"
is after the best amplitude, which leaves what differs in kind; the transfer of the shipped head onto itself
shows what the method alone loses.
"""

from __future__ import annotations

import argparse
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.head import Head, load_head
from phonanim.morphs import plain
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.rig.transfer import transfer

Array = NDArray[np.float64]
DATA = Path(os.environ.get("PHONANIM_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))
MOVED = 0.1  # of a shape's largest motion


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("head", type=Path, nargs="?", default=DATA / "rigs" / "ict_head.npz")
    model, other = load_head(), read_ict(options.parse_args().head)
    started = time.perf_counter()
    made, _, report = transfer(model, shipped_landmarks(), bare(other))
    seconds = time.perf_counter() - started
    face = other.parts["face"]
    names = {plain(name): number for number, name in enumerate(other.targets)}
    pairs = {
        name: (delta[face], other.deltas[names[plain(name)]][face])
        for name, delta in zip(made.targets, made.deltas, strict=True)
        if name.startswith(("jaw", "mouth")) and plain(name) in names
    }
    again, _, _ = transfer(model, shipped_landmarks(), bare(model))
    skin = model.parts["skin"]
    own = [
        error(*(head.deltas[i][skin] for head in (again, model)))
        for i, name in enumerate(model.targets)
        if name.startswith(("jaw", "mouth"))
    ]
    print("| shape | error | scaled | amplitude |\n|---|---|---|---|")
    for name, (ours, theirs) in pairs.items():
        amplitude = float((ours * theirs).sum() / (ours * ours).sum())
        figures = error(ours, theirs), error(ours * amplitude, theirs), amplitude
        print(f"| {name} | " + " | ".join(f"{figure:.2f}" for figure in figures) + " |")
    print(
        f"\nmedian {np.median([error(*pair) for pair in pairs.values()]):.2f}; "
        f"onto itself {np.median(own):.3f}, at most {max(own):.3f}"
    )
    print(f"{seconds:.1f} s, {report.matched:.0%} matched, {report.flipped} triangles turned over")


def read_ict(path: Path) -> Head:
    """ICT-FaceKit's head with its shapes, centimetres."""
    with np.load(path) as stored:
        quads = stored["quads"].astype(np.int64)
        four = quads[:, 3] < len(stored["V"])
        parts = {
            name: slice(*span)
            for name, span in zip(stored["part_names"].tolist(), stored["parts"].tolist(), strict=True)
        }
        deltas = stored["delta_i16"] * float(stored["delta_scale"])
        vertices, names = stored["V"].astype(np.float64), tuple(stored["names"].tolist())
    triangles = np.concatenate([quads[:, :3], quads[four][:, [0, 2, 3]]])
    return Head(vertices, triangles, parts, names, deltas, np.full_like(vertices, 0.3))


def bare(head: Head) -> Head:
    """A head without its shapes."""
    return replace(head, targets=(), deltas=np.zeros((0, *head.vertices.shape)))


def error(ours: Array, theirs: Array) -> float:
    """Mean distance as a fraction of the mean motion, where the shape moves."""
    motion = np.linalg.norm(theirs, axis=1)
    moved = motion > MOVED * motion.max()
    return float(np.linalg.norm(ours - theirs, axis=1)[moved].mean() / motion[moved].mean())


if __name__ == "__main__":
    main()
