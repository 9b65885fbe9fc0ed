"""Make lexicon/masks: the regions of the reference face's landmarks and of the shipped head.

    python scripts/build_masks.py

A landmark's region follows from where it lies on the shipped head at rest, in millimetres from the middle of
the eyes (x to the head's left, y up). A vertex of the skin belongs to the regions of the landmark that is
nearest to it, when it is near at all. Tongue and teeth are parts of the head by themselves.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.lexicon import LEXICON
from phonanim.face.model import OUTER_LIPS, SUBNASALE
from phonanim.rig.head import load_head
from phonanim.rig.landmarks import shipped_landmarks

MOUTH_MARGIN = 12.0  # mm around the red of the lips that move with it
CHEEK_TOP = -20.0  # mm: the lower rim of the eye socket
CHIN_HALF = 32.0  # mm from the middle: the chin and the jaw below the mouth, not yet the cheek
NEAR = 12.0  # mm from a vertex to its landmark
CHIN, LIP_CORNERS = 152, (61, 291)
Array = NDArray[np.float64]


def main(folder: Path = LEXICON / "masks") -> None:
    head, spots = load_head(), shipped_landmarks()
    points = spots.of(head.vertices)
    middle = points[[33, 133, 362, 263]].mean(axis=0)
    numbers = regions((points - middle) * 1000)
    write(folder / "landmarks.json", "MediaPipe face-mesh numbers", numbers)
    skin = head.vertices[head.parts["skin"]]
    apart = np.linalg.norm(skin[:, None] - points[None], axis=2) * 1000
    nearest, close = apart.argmin(axis=1), apart.min(axis=1) < NEAR
    rows = {name: np.flatnonzero(close & np.isin(nearest, mine)) for name, mine in numbers.items()}
    rows["tongue"] = np.arange(*head.parts["tongue"].indices(len(head.vertices)))
    teeth = [np.arange(*head.parts[part].indices(len(head.vertices))) for part in ("teeth_u", "teeth_l")]
    rows["teeth"] = np.concatenate(teeth)
    write(folder / "head.json", "vertices of lexicon/rigs/head.glb, its parts end to end", rows)


def regions(points: Array) -> dict[str, NDArray[np.int64]]:
    """Landmarks by region, (478, 3) mm -> numbers; lips lie in mouth, and that in lower."""
    ring = points[list(OUTER_LIPS), :2]
    depth = np.array([signed_distance(point, ring) for point in points[:, :2]])
    lips, near = depth >= -0.01, depth > -MOUTH_MARGIN
    upper = points[:, 1] > CHEEK_TOP
    below_nose = points[:, 1] < points[SUBNASALE, 1]
    corner = points[list(LIP_CORNERS), 1].mean()
    jaw = ~lips & (points[:, 1] < corner) & (np.abs(points[:, 0]) < CHIN_HALF)
    cheeks = ~lips & ~jaw & ~upper & (np.abs(points[:, 0]) > np.abs(ring[:, 0]).max() / 2)
    masks = {
        "lips": lips,
        "mouth": near & below_nose,
        "jaw": jaw,
        "cheeks": cheeks,
        "lower": ~upper,
        "upper": upper,
    }
    return {name: np.flatnonzero(mask) for name, mask in masks.items()}


def signed_distance(point: Array, ring: Array) -> float:
    """How far inside a closed outline a point lies, (2,) and (n, 2) mm; negative outside."""
    starts, sides = ring, np.roll(ring, -1, axis=0) - ring
    along = np.clip(((point - starts) * sides).sum(axis=1) / (sides**2).sum(axis=1), 0, 1)
    distance = np.linalg.norm(starts + along[:, None] * sides - point, axis=1).min()
    ends = starts + sides
    crossed = (starts[:, 1] > point[1]) != (ends[:, 1] > point[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = starts[:, 0] + (point[1] - starts[:, 1]) / sides[:, 1] * sides[:, 0]
    inside = bool((crossed & (point[0] < x)).sum() % 2)
    return float(distance if inside or distance < 1e-9 else -distance)


def write(path: Path, what: str, masks: dict[str, NDArray[np.int64]]) -> None:
    """One region a line."""
    path.parent.mkdir(exist_ok=True)
    source = json.dumps(f"{what}; made by scripts/build_masks.py")
    lines = [f' "source": {source}', *(f' "{name}": {json.dumps(r.tolist())}' for name, r in masks.items())]
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    print(path, {name: len(rows) for name, rows in masks.items()})


if __name__ == "__main__":
    main()
