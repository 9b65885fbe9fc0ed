"""Find the reference face's landmarks on the shipped head and write lexicon/rigs/arkit.landmarks.csv.

MediaPipe's face mesh tracks a picture of the head; each landmark is cast back onto the skin, both sides
are made to agree, and the inner lips are put on the rims that meet when the mouth is shut (a tracker
cannot see two rims in a closed mouth). MediaPipe 0.10.21 pins numpy below 2, so it has an environment
of its own:

    python -m venv track && track/bin/pip install -e '.[track]' pillow
    track/bin/python scripts/fit_head_landmarks.py [-o TABLE.csv] [--picture head.png]
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.face import INNER_LIP_PAIRS, INNER_LIPS, MOUTH_CORNER_LEFT, MOUTH_CORNER_RIGHT, OUTER_LIPS
from phonanim.head import Head, load_head
from phonanim.inventory import LEXICON
from phonanim.raster import Picture, rasterize
from phonanim.rig.landmarks import MeshLandmarks, write_landmarks

Array = NDArray[np.float64]

TABLE = LEXICON / "rigs" / "arkit.landmarks.csv"
PUPILS = {468: "eye_r", 473: "eye_l"}
IRISES = (469, 470, 471, 472, 474, 475, 476, 477)
UPPER_INNER = (191, 80, 81, 82, 13, 312, 311, 310, 415)
LOWER_INNER = (95, 88, 178, 87, 14, 317, 402, 318, 324)
RIM_DEPTH = 0.006  # metres behind the front of the lips: deeper than this lies the slit of the mouth
RIM_REACH = 60  # pixels of LIPS, 3 mm: the tracker finds the crease of closed lips within that


@dataclass(frozen=True)
class View:
    """An orthographic view from the front: pixels per metre, and the pixel where the eyes' middle falls."""

    scale: float
    centre: tuple[float, float]
    height: int
    width: int

    def pixels(self, points: Array, head: Head) -> Array:
        """Column, row and nearness of points on the head, (n, 3) metres -> (n, 3)."""
        moved = (points - between_eyes(head)) * self.scale
        return np.asarray(moved * (1, -1, 1) + (*self.centre, 0))


# Chin to crown fill the first; the second shows the lips alone, twenty pixels to the millimetre.
FACE = View(3200.0, (512.0, 400.0), 1024, 1024)
LIPS = View(20000.0, (800.0, -900.0), 800, 1600)


def main() -> None:
    """Track, cast, make symmetric, mend the inner lips, write."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("-o", "--output", type=Path, default=TABLE)
    options.add_argument("--picture", type=Path, help="where to draw the landmarks, to look at")
    chosen = options.parse_args()
    head = load_head()
    picture = draw(head)
    seen = track(picture)
    seen = (seen + mirror(seen)[partners(head)]) / 2
    landmarks = put_on_rims(head, cast(head, seen))
    write_landmarks(chosen.output, landmarks)
    report(head, landmarks)
    if chosen.picture:
        mark(picture, FACE.pixels(landmarks.of(head.vertices), head), chosen.picture)


def between_eyes(head: Head) -> Array:
    """The point between the eyeballs, (3,) metres."""
    eyes = [head.vertices[head.parts[part]].mean(axis=0) for part in PUPILS.values()]
    return np.asarray(np.mean(eyes, axis=0))


def draw(head: Head) -> NDArray[np.uint8]:
    """A picture of the head as a camera sees it, (height, width, 3)."""
    seen = rasterize(
        FACE.pixels(head.vertices, head).astype(np.float32), head.triangles, FACE.height, FACE.width
    )
    light = np.clip(normals(head) @ (0.2, 0.4, 0.9), 0, 1)[:, None] * 0.5 + 0.5
    pixels = seen.covered()
    image = np.full((FACE.height * FACE.width, 3), 0.85)
    image[pixels] = seen.at(pixels, (head.colors ** (1 / 2.2) * light).astype(np.float32))
    return (image.reshape(FACE.height, FACE.width, 3).clip(0, 1) * 255).astype(np.uint8)


def normals(head: Head) -> Array:
    """Outward directions at the vertices, (n, 3)."""
    a, b, c = (head.vertices[head.triangles[:, k]] for k in range(3))
    summed = np.zeros_like(head.vertices)
    for corner in range(3):
        np.add.at(summed, head.triangles[:, corner], np.cross(b - a, c - a))
    return np.asarray(summed / np.linalg.norm(summed, axis=1, keepdims=True).clip(1e-12))


def track(picture: NDArray[np.uint8]) -> Array:
    """The face mesh that MediaPipe sees in a picture, (478, 2) pixels."""
    import mediapipe

    with mediapipe.solutions.face_mesh.FaceMesh(static_image_mode=True, refine_landmarks=True) as mesh:
        faces = mesh.process(picture).multi_face_landmarks
    if not faces:
        raise SystemExit("MediaPipe sees no face in the picture of the head")
    return np.array([(p.x * FACE.width, p.y * FACE.height) for p in faces[0].landmark])


def partners(head: Head) -> NDArray[np.int64]:
    """The landmark on the other side for each, (478,), seen on an open mouth, where none coincide."""
    from scipy.optimize import linear_sum_assignment

    opened = head.vertices + 0.5 * head.deltas[head.targets.index("jawOpen")]
    seen = track(draw(replace(head, vertices=opened)))
    apart = np.linalg.norm(seen[:, None] - mirror(seen)[None], axis=2) ** 2
    return np.asarray(linear_sum_assignment(apart)[1])


def mirror(seen: Array) -> Array:
    """Points of the picture on the other side of the nose, (landmarks, 2) pixels."""
    return np.asarray(seen * (-1, 1) + (2 * FACE.centre[0], 0))


def cast(head: Head, seen: Array) -> MeshLandmarks:
    """Points of the picture put on the mesh: pupils on the eyeballs, all else on the skin."""
    numbers = np.arange(len(seen))
    eyes = np.isin(numbers, [*PUPILS, *IRISES])
    skin = hit(head, ("skin",), FACE, seen)
    ball = hit(head, ("eye_l", "eye_r"), FACE, seen)
    corners = np.where(eyes[:, None], ball[0], skin[0])
    return MeshLandmarks(numbers, corners, np.where(eyes[:, None], ball[1], skin[1]))


def hit(head: Head, parts: tuple[str, ...], view: View, seen: Array) -> tuple[NDArray[np.int64], Array]:
    """The first surface of some parts behind each pixel, or behind the nearest pixel that has one."""
    picture = show(head, parts, view)
    covered = np.column_stack(np.divmod(picture.covered(), view.width))[:, ::-1]
    place = np.array([covered[((covered - point) ** 2).sum(axis=1).argmin()] for point in seen])
    face = picture.face[place[:, 1], place[:, 0]]
    inside = np.linalg.norm(place - seen, axis=1) < 1
    spot = np.column_stack([np.where(inside[:, None], seen, place), np.ones(len(seen))])
    weights = np.einsum("ncj,nj->nc", picture.planes[face].astype(float), spot).clip(0)
    return picture.corners[face], weights / weights.sum(axis=1, keepdims=True)


def show(head: Head, parts: tuple[str, ...], view: View) -> Picture:
    """Some parts of the head alone."""
    kept = np.concatenate([np.arange(len(head.vertices))[head.parts[part]] for part in parts])
    triangles = head.triangles[np.isin(head.triangles, kept).all(axis=1)]
    return rasterize(view.pixels(head.vertices, head).astype(np.float32), triangles, view.height, view.width)


def put_on_rims(head: Head, landmarks: MeshLandmarks) -> MeshLandmarks:
    """Move the inner-lip landmarks to the rims of the lips above and below the slit of the mouth."""
    depth = show(head, ("skin",), LIPS).depth / LIPS.scale
    rows = np.flatnonzero(np.isin(landmarks.numbers, UPPER_INNER + LOWER_INNER))
    seen = LIPS.pixels(landmarks.of(head.vertices)[rows], head)[:, :2]
    upper = np.isin(landmarks.numbers[rows], UPPER_INNER)
    seen[:, 1] = [rim(depth[:, round(x)], round(y), above) for (x, y), above in zip(seen, upper, strict=True)]
    corners, weights = landmarks.corners.copy(), landmarks.weights.copy()
    corners[rows], weights[rows] = hit(head, ("skin",), LIPS, seen)
    return MeshLandmarks(landmarks.numbers, corners, weights)


def rim(depth: Array, start: int, above: bool) -> int:
    """The row of a pixel column where a lip ends: at the slit, or at the crease where there is none."""
    near = np.arange(start - RIM_REACH, start + RIM_REACH)
    lips = np.max(depth[near])
    slit = near[depth[near] < lips - RIM_DEPTH]
    if len(slit) == 0:
        return int(near[depth[near].argmin()])
    return int(slit[0] - 1 if above else slit[-1] + 1)


def report(head: Head, landmarks: MeshLandmarks) -> None:
    """Print the gap between the lips at rest and the width of the mouth, in millimetres."""
    points = landmarks.of(head.vertices) * 1000
    gaps = [points[upper, 1] - points[lower, 1] for upper, lower in INNER_LIP_PAIRS]
    width = points[MOUTH_CORNER_LEFT, 0] - points[MOUTH_CORNER_RIGHT, 0]
    print("lip gaps at rest (mm):", np.round(gaps, 2).tolist(), f"mouth width: {width:.1f} mm")


def mark(picture: NDArray[np.uint8], seen: Array, path: Path) -> None:
    """Write the picture with a dot per landmark: inner lips red, outer lips blue, others green."""
    from PIL import Image, ImageDraw

    image = Image.fromarray(picture).resize((FACE.width * 2, FACE.height * 2))
    pen = ImageDraw.Draw(image)
    for number, (x, y) in enumerate(seen[:, :2] * 2):
        colour = "red" if number in INNER_LIPS else "blue" if number in OUTER_LIPS else "lime"
        pen.ellipse((x - 2, y - 2, x + 2, y + 2), fill=colour)
    image.save(path)


if __name__ == "__main__":
    main()
