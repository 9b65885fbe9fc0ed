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
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.lexicon import LEXICON
from phonanim.face.model import INNER_LIP_PAIRS, INNER_LIPS, MOUTH_CORNER_LEFT, MOUTH_CORNER_RIGHT, OUTER_LIPS
from phonanim.rig.geometry import vertex_normals
from phonanim.rig.head import Head, load_head
from phonanim.rig.landmarks import MeshLandmarks, write_landmarks
from phonanim.rig.rims import View, put_on_rims, surface_at_pixels

Array = NDArray[np.float64]

TABLE = LEXICON / "rigs" / "arkit.landmarks.csv"
PUPILS = {468: "eye_r", 473: "eye_l"}
IRISES = (469, 470, 471, 472, 474, 475, 476, 477)
SIZE = 1024  # pixels, square
CENTRE = (512.0, 400.0)  # the pixel where the point between the eyes falls


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
    landmarks = put_on_rims(head.vertices, triangles_of(head, ("skin",)), cast(head, seen))
    write_landmarks(chosen.output, landmarks)
    report(head, landmarks)
    if chosen.picture:
        mark(picture, view_of(head).pixels(landmarks.of(head.vertices)), chosen.picture)


def view_of(head: Head) -> View:
    """Chin to crown fill the picture."""
    eyes = [head.vertices[head.parts[part]].mean(axis=0) for part in PUPILS.values()]
    return View(3200.0, np.asarray(np.mean(eyes, axis=0)), CENTRE, SIZE, SIZE)


def draw(head: Head) -> NDArray[np.uint8]:
    """A picture of the head as a camera sees it, (height, width, 3)."""
    seen = view_of(head).show(head.vertices, head.triangles)
    light = (
        np.clip(vertex_normals(head.vertices, head.triangles) @ (0.2, 0.4, 0.9), 0, 1)[:, None] * 0.5 + 0.5
    )
    pixels = seen.covered()
    image = np.full((SIZE * SIZE, 3), 0.85)
    image[pixels] = seen.at(pixels, (head.colors ** (1 / 2.2) * light).astype(np.float32))
    return (image.reshape(SIZE, SIZE, 3).clip(0, 1) * 255).astype(np.uint8)


def track(picture: NDArray[np.uint8]) -> Array:
    """The face mesh that MediaPipe sees in a picture, (478, 2) pixels."""
    import mediapipe

    with mediapipe.solutions.face_mesh.FaceMesh(static_image_mode=True, refine_landmarks=True) as mesh:
        faces = mesh.process(picture).multi_face_landmarks
    if not faces:
        raise SystemExit("MediaPipe sees no face in the picture of the head")
    return np.array([(p.x * SIZE, p.y * SIZE) for p in faces[0].landmark])


def partners(head: Head) -> NDArray[np.int64]:
    """The landmark on the other side for each, (478,), seen on an open mouth, where none coincide."""
    from scipy.optimize import linear_sum_assignment

    opened = head.vertices + 0.5 * head.deltas[head.targets.index("jawOpen")]
    seen = track(draw(replace(head, vertices=opened)))
    apart = np.linalg.norm(seen[:, None] - mirror(seen)[None], axis=2) ** 2
    return np.asarray(linear_sum_assignment(apart)[1])


def mirror(seen: Array) -> Array:
    """Points of the picture on the other side of the nose, (landmarks, 2) pixels."""
    return np.asarray(seen * (-1, 1) + (2 * CENTRE[0], 0))


def cast(head: Head, seen: Array) -> MeshLandmarks:
    """Points of the picture put on the mesh: pupils on the eyeballs, all else on the skin."""
    numbers, view = np.arange(len(seen)), view_of(head)
    eyes = np.isin(numbers, [*PUPILS, *IRISES])[:, None]
    skin, balls = (
        surface_at_pixels(view, view.show(head.vertices, triangles_of(head, parts)), seen)
        for parts in (("skin",), ("eye_l", "eye_r"))
    )
    return MeshLandmarks(numbers, np.where(eyes, balls[0], skin[0]), np.where(eyes, balls[1], skin[1]))


def triangles_of(head: Head, parts: tuple[str, ...]) -> NDArray[np.int64]:
    """The triangles of some parts."""
    rows = np.concatenate([np.arange(len(head.vertices))[head.parts[part]] for part in parts])
    return head.triangles[np.isin(head.triangles, rows).all(axis=1)]


def report(head: Head, landmarks: MeshLandmarks) -> None:
    """Print the gap between the lips at rest and the width of the mouth, in millimetres."""
    points = landmarks.of(head.vertices) * 1000
    gaps = [points[upper, 1] - points[lower, 1] for upper, lower in INNER_LIP_PAIRS]
    width = points[MOUTH_CORNER_LEFT, 0] - points[MOUTH_CORNER_RIGHT, 0]
    print("lip gaps at rest (mm):", np.round(gaps, 2).tolist(), f"mouth width: {width:.1f} mm")


def mark(picture: NDArray[np.uint8], seen: Array, path: Path) -> None:
    """Write the picture with a dot per landmark: inner lips red, outer lips blue, others green."""
    from PIL import Image, ImageDraw

    image = Image.fromarray(picture).resize((SIZE * 2, SIZE * 2))
    pen = ImageDraw.Draw(image)
    for number, (x, y) in enumerate(seen[:, :2] * 2):
        colour = "red" if number in INNER_LIPS else "blue" if number in OUTER_LIPS else "lime"
        pen.ellipse((x - 2, y - 2, x + 2, y + 2), fill=colour)
    image.save(path)


if __name__ == "__main__":
    main()
