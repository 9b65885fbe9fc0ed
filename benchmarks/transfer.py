"""Deformation transfer onto a head whose artist made the same shapes: how far apart the two are, and why.

    python benchmarks/transfer.py [ict_head.npz]

The shipped head's shapes are transferred to ICT-FaceKit's bare head (MIT; 24,591 vertices) and compared with
ICT's own 20 jaw and mouth shapes (of those that have sides, the left; mouthClose, a corrective, on top of
jawOpen): the mean distance of the face's vertices as a fraction of the mean motion, over the vertices that
the shape moves by a tenth of its largest motion or more. What bounds it:

    scaled      after the best amplitude: what differs in kind
    elsewhere   scaled, and each vertex may move as the best one within 6 mm, the same for all shapes:
                no better correspondence could do more
    mixture     the best linear combination of all 52 transferred shapes: what the model's artist could say
    there, back ICT's own shapes transferred to the shipped head and back: what the method loses, twice

The transfer of the shipped head onto itself shows what is lost where nothing has to be matched.
"""

from __future__ import annotations

import argparse
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from phonanim.face.model import INNER_LIP_PAIRS
from phonanim.rig import load_rig
from phonanim.rig.geometry import face_normals
from phonanim.rig.head import Head, load_head
from phonanim.rig.landmarks import MeshLandmarks, shipped_landmarks
from phonanim.rig.morphs import plain_name
from phonanim.rig.transfer import transfer

Array = NDArray[np.float64]
Pair = tuple[Array, Array]  # a shape's motion as made and as the artist's, (face vertices, 3) cm
DATA = Path(os.environ.get("PHONANIM_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))
MOVED = 0.1  # of a shape's largest motion
AROUND = 0.6  # cm
COLUMNS = ("error", "amplitude", "scaled", "elsewhere", "mixture", "there, back")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("head", type=Path, nargs="?", default=DATA / "rigs" / "ict_head.npz")
    model, other = load_head(), read_ict(options.parse_args().head)
    started = time.perf_counter()
    made, spots, report = transfer(model, shipped_landmarks(), bare(other))
    seconds = time.perf_counter() - started
    pairs = motions(made, other, model)
    columns = [
        [error(*pair) for pair in pairs.values()],
        [amplitude(*pair) for pair in pairs.values()],
        [error(*scaled(*pair)) for pair in pairs.values()],
        [error(*pair) for pair in elsewhere(list(pairs.values()), other.vertices[other.parts["face"]])],
        [error(mixture(made, other, theirs), theirs) for _, theirs in pairs.values()],
        [error(*pair) for pair in motions(there_and_back(other, spots, model), other, model).values()],
    ]
    print(f"| shape | {' | '.join(COLUMNS)} |\n|{'---|' * (len(COLUMNS) + 1)}")
    for name, *figures in [*zip(pairs, *columns, strict=True), ("median", *np.median(columns, axis=1))]:
        print(f"| {name} | " + " | ".join(f"{figure:.2f}" for figure in figures) + " |")
    again, _, _ = transfer(model, shipped_landmarks(), bare(model))
    own = [error(*pair) for pair in motions(again, model, model, "skin").values()]
    print(f"\nonto itself {np.median(own):.3f}, at most {max(own):.3f}")
    for weights in ((0, 0), (1, 0), (1, 1)):
        ours, theirs = gaps(made, spots, weights, 10), gaps(model, shipped_landmarks(), weights, 1000)
        print(f"lips, jawOpen {weights[0]}, mouthClose {weights[1]}: {ours} mm; shipped head {theirs} mm")
    print(
        f"{seconds:.1f} s, {report.matched:.0%} matched, {report.straightened} shapes mended, "
        f"{report.flipped} triangles turned, {turned(made, load_rig('arkit').poses)} in the eight poses, "
        f"{turned(made, posed(('jawOpen', 'mouthClose')))} under jawOpen and mouthClose"
    )


def motions(made: Head, other: Head, model: Head, part: str = "face") -> dict[str, Pair]:
    """What each jaw and mouth shape of the model moves, as made and as the artist has it."""
    rows = other.parts[part]
    ours, theirs = (
        dict(zip(map(plain_name, h.targets), h.deltas[:, rows], strict=True)) for h in (made, other)
    )
    pairs = {}
    for name in map(plain_name, model.targets):
        mirrored = name.endswith("right") and name not in ("jawright", "mouthright")
        if name.startswith(("jaw", "mouth")) and name in ours and name in theirs and not mirrored:
            opened = float(name == "mouthclose")
            pairs[name] = tuple(moved[name] + opened * moved["jawopen"] for moved in (ours, theirs))
    return {name: pairs[plain_name(name)] for name in model.targets if plain_name(name) in pairs}


def there_and_back(other: Head, spots: MeshLandmarks, model: Head) -> Head:
    """A head's own shapes, transferred to the model's bare mesh and back."""
    metres = replace(other, vertices=other.vertices / 100, deltas=other.deltas / 100)
    there, marks, _ = transfer(metres, spots, bare(model))
    return transfer(there, marks, bare(other))[0]


def elsewhere(pairs: list[Pair], points: Array) -> list[Pair]:
    """The pairs with the best of the near vertices for each, the same in all shapes, amplitudes at best."""
    sizes = [np.sqrt((theirs**2).sum()) for _, theirs in pairs]
    alike = [scaled(*pair) for pair in pairs]
    ours, theirs = (
        np.concatenate([pair[side] / size for pair, size in zip(alike, sizes, strict=True)], axis=1)
        for side in (0, 1)
    )
    near = cKDTree(points).query_ball_point(points, AROUND)
    best = [
        rows[((ours[rows] - own) ** 2).sum(axis=1).argmin()] for rows, own in zip(near, theirs, strict=True)
    ]
    return [scaled(moved[best], goal) for moved, goal in pairs]


def mixture(made: Head, other: Head, theirs: Array) -> Array:
    """The linear combination of all shapes that comes nearest to a motion where that moves."""
    shapes, moved = made.deltas[:, other.parts["face"]], moving(theirs)
    table = shapes[:, moved].reshape(len(shapes), -1).T
    weights = np.linalg.lstsq(table, theirs[moved].ravel(), rcond=1e-3)[0]
    return np.asarray(np.tensordot(weights, shapes, axes=1))


def posed(names: tuple[str, ...]) -> Array:
    """One pose of ARKit's controls, those named at full weight, (1, controls)."""
    return np.array([[float(name in names) for name in load_rig("arkit").controls]])


def turned(head: Head, poses: Array) -> int:
    """Triangles that poses of ARKit's controls, (poses, controls), turn by more than a right angle."""
    still = face_normals(head.vertices, head.triangles)
    shapes = head.shape(head.weights(poses, load_rig("arkit").controls))
    return sum(int(((face_normals(p, head.triangles) * still).sum(axis=1) < 0).sum()) for p in shapes)


def scaled(ours: Array, theirs: Array) -> Pair:
    """A motion at its best amplitude, and the other."""
    return ours * amplitude(ours, theirs), theirs


def amplitude(ours: Array, theirs: Array) -> float:
    """What one motion is to be multiplied by to come nearest to another."""
    return float((ours * theirs).sum() / (ours * ours).sum())


def gaps(head: Head, marks: MeshLandmarks, weights: tuple[float, float], millimetres: float) -> str:
    """The least and the largest gap between the inner lips under jawOpen and mouthClose."""
    moved = head.shape(head.weights(np.array([weights]), ("jawOpen", "mouthClose")))[0]
    upper, lower = (marks.take(side).of(moved) for side in zip(*INNER_LIP_PAIRS, strict=True))
    apart = (upper - lower)[:, 1] * millimetres
    return f"{apart.min():.1f} to {apart.max():.1f}"


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
    moved = moving(theirs)
    motion = np.linalg.norm(theirs, axis=1)[moved]
    return float(np.linalg.norm(ours - theirs, axis=1)[moved].mean() / motion.mean())


def moving(theirs: Array) -> NDArray[np.bool_]:
    """Where a shape moves a face by a tenth of its largest motion or more."""
    motion = np.linalg.norm(theirs, axis=1)
    return np.asarray(motion > MOVED * motion.max())


if __name__ == "__main__":
    main()
