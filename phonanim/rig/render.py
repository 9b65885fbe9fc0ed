"""Draw pictures of a head: view, light and shading, without a graphics card."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from phonanim.media.raster import Picture, rasterize
from phonanim.rig.head import Head


@dataclass(frozen=True)
class View:
    """A camera that looks at `centre` (metres) and shows `span` metres from top to bottom.

    `yaw` and `pitch` in degrees turn the head to its left and down; `distance` in metres sets the
    perspective; `samples` squared are averaged into each pixel. One sample takes a quarter of the time of two
    and only smooths the outlines.
    """

    centre: tuple[float, float, float]
    span: float
    height: int = 200
    width: int = 200
    yaw: float = 0.0
    pitch: float = 0.0
    distance: float = 0.9
    samples: int = 2


@dataclass(frozen=True)
class Light:
    """A light: its direction (towards the light, in the camera's axes) and its linear colour."""

    direction: tuple[float, float, float]
    color: tuple[float, float, float]


LIGHTS = (
    Light((-0.45, 0.55, 0.75), (1.45, 1.34, 1.24)),
    Light((0.85, 0.05, 0.40), (0.26, 0.32, 0.42)),
    Light((0.55, 0.45, -0.65), (0.85, 0.90, 1.00)),
)
SKY, GROUND = (0.24, 0.26, 0.30), (0.12, 0.085, 0.07)
WRAP = 0.25  # light beyond the terminator, as in skin
TONE_STEPS, TONE_LIMIT = 8192, 4  # steps per unit of linear light, and the brightest light
SHOULDER = 0.6  # light above this is compressed
MOVED = 1e-5  # metres; less counts as no motion
AROUND = 1.5  # picture height of a head with unknown parts, relative to the height of what moves
OUTLINE = 0.002  # metres of depth between neighbouring pixels that make an edge
BACKDROP = ((0.035, 0.040, 0.050), (0.085, 0.093, 0.110))  # bottom and top, linear

# The reflection in an eye: how bright, the cosines from its edge to its inside, and where the ball shows it.
EYES, GLINT, WINDOW = ("eye_l", "eye_r"), 0.9, (0.987, 0.992)
MIRROR = (0.0, 0.13, 1.0)  # in the camera's axes; below the upper lid

# Highlight strength and sharpness of each part.
GLOSS = {
    "skin": (0.10, 14.0),
    "tongue": (0.25, 30.0),
    "teeth_u": (0.35, 50.0),
    "teeth_l": (0.35, 50.0),
    "eye_l": (0.10, 30.0),
    "eye_r": (0.10, 30.0),
    "hair": (0.16, 22.0),
    "shirt": (0.02, 8.0),
}
# Crevices are darkened by their depth behind their surroundings (Luft, Colditz, Deussen 2006, "Image
# enhancement by unsharp masking the depth buffer"): radius in metres, and how fast per metre.
CREVICES = ((0.003, 130.0), (0.011, 85.0))


def lower_face(head: Head, size: int = 200, yaw: float = 16.0) -> View:
    """The view from below the eyes to the chin, slightly from the side, of a head with teeth and eyes."""
    teeth = head.vertices[head.parts["teeth_u"]]
    eyes = head.vertices[head.parts["eye_l"]]
    middle = (teeth.min(axis=0) + teeth.max(axis=0)) / 2
    span = 1.45 * (eyes.mean(axis=0)[1] - middle[1])
    centre = (0.0, float(middle[1] - 0.16 * span), float(teeth[:, 2].max()))
    return View(centre, float(span), size, size, yaw)


def whole_head(head: Head, height: int = 512, width: int = 512, yaw: float = 0.0) -> View:
    """The view of face and neck, or, without parts named skin and eyes, of what the shapes move."""
    if not {"skin", "eye_l"} <= set(head.parts):
        return _around_moved(head, height, width, yaw)
    crown = head.vertices[head.parts["skin"], 1].max()
    eyes = head.vertices[head.parts["eye_l"]].mean(axis=0)
    span = 2.55 * (crown - eyes[1])
    centre = (0.0, float(crown + 0.11 * span - span / 2), float(eyes[2] - 0.05))
    return View(centre, float(span), height, width, yaw)


def _around_moved(head: Head, height: int, width: int, yaw: float) -> View:
    moved = np.abs(head.deltas).max(axis=(0, 2), initial=0.0) > MOVED
    seen = head.vertices[moved if moved.any() else slice(None)]
    low, high = seen.min(axis=0), seen.max(axis=0)
    across, up, ahead = ((low + high) / 2).tolist()
    return View((across, up, ahead), AROUND * float(high[1] - low[1]), height, width, yaw)


def render(vertices: NDArray[np.float64], head: Head, view: View) -> NDArray[np.uint8]:
    """Draw a head, (n, 3) metres -> (height, width, 3) sRGB."""
    height, width = view.height * view.samples, view.width * view.samples
    seen = to_camera_axes(vertices, view)
    picture = rasterize(project_vertices(seen, view), head.triangles, height, width)
    pixels = picture.covered()
    light = picture.at(pixels, light_vertices(seen, head)) * ambient_occlusion(picture, view, pixels)[:, None]
    add_glints(light, picture, pixels, seen, head)
    image = backdrop(height, width).copy()
    image.reshape(-1, 3)[pixels] = light
    return to_srgb(
        downsample(image, view.samples) if view.samples > 1 else soften_edges(image, picture.depth)
    )


def to_camera_axes(vertices: NDArray[np.float64], view: View) -> NDArray[np.float32]:
    """Vertices in the camera's axes: x right, y up, z to the viewer, metres from the centre."""
    yaw, pitch = np.radians([view.yaw, view.pitch])
    about_y = np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
    about_x = np.array([[1, 0, 0], [0, np.cos(pitch), -np.sin(pitch)], [0, np.sin(pitch), np.cos(pitch)]])
    seen = (vertices - np.array(view.centre)) @ (about_x @ about_y).T
    return np.asarray(seen, np.float32)


def project_vertices(seen: NDArray[np.float32], view: View) -> NDArray[np.float32]:
    """Pixels right and down, and nearness in metres (at the centre)."""
    scale = view.distance / (view.distance - seen[:, 2:])
    pixels = view.height * view.samples / view.span
    middle = np.array([view.width, view.height], np.float32) * view.samples / 2 - 0.5
    places = seen[:, :2] * scale * np.array([pixels, -pixels], np.float32) + middle
    return np.hstack([places, (scale - 1) * view.distance]).astype(np.float32)


def light_vertices(seen: NDArray[np.float32], head: Head) -> NDArray[np.float32]:
    """Linear light from each vertex towards the viewer, (n, 3)."""
    normal = vertex_normals(seen, head.triangles)
    strength, power = part_gloss(head)
    diffuse = ambient_light(normal[:, 1:2])
    highlight = np.zeros_like(diffuse)
    for light in LIGHTS:
        towards = normalized(light.direction)
        half = normalized(towards + np.array([0, 0, 1], np.float32))
        tint = np.array(light.color, np.float32)
        diffuse += np.clip((normal @ towards + WRAP) / (1 + WRAP), 0, None)[:, None] * tint
        highlight += np.clip(normal @ half, 0, None)[:, None] ** power * tint
    return np.asarray(head.colors * diffuse + strength * highlight, np.float32)


def add_glints(
    light: NDArray[np.float32],
    picture: Picture,
    pixels: NDArray[np.int64],
    seen: NDArray[np.float32],
    head: Head,
) -> None:
    """Add the reflection of a window in the eyes to (p, 3) light at pixels: it is finer than the vertices."""
    faces = picture.face.ravel()[pixels]
    half = normalized(MIRROR)
    for rows in (head.parts[name] for name in EYES if name in head.parts):
        first = picture.corners[:, 0]
        here = np.flatnonzero(((first >= rows.start) & (first < rows.stop))[faces])
        if not len(here):
            continue
        row, column = np.divmod(pixels[here], picture.face.shape[1])
        places = np.stack([column, row, np.ones_like(row)], axis=1).astype(np.float32)
        shares = np.einsum("pcj,pj->pc", picture.planes[faces[here]], places)
        ball = seen[rows]
        out = seen[picture.corners[faces[here]]] - (ball.min(axis=0) + ball.max(axis=0)) / 2
        normal = np.einsum("pc,pck->pk", shares, out)
        facing = normal @ half / np.linalg.norm(normal, axis=1)
        light[here] += GLINT * np.clip((facing - WINDOW[0]) / (WINDOW[1] - WINDOW[0]), 0, 1)[:, None]


def part_gloss(head: Head) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Strength and sharpness of the highlight at each vertex, (n, 1) and (n, 1)."""
    gloss = np.tile(np.array(GLOSS["skin"], np.float32), (len(head.vertices), 1))
    for name, rows in head.parts.items():
        gloss[rows] = GLOSS.get(name, GLOSS["skin"])
    return gloss[:, :1], gloss[:, 1:]


def ambient_light(up: NDArray[np.float32]) -> NDArray[np.float32]:
    """Light from sky and ground on a surface whose normal rises by `up`, (p, 1) -> (p, 3)."""
    share = (up + 1) / 2
    mixed = share * np.array(SKY, np.float32) + (1 - share) * np.array(GROUND, np.float32)
    return np.asarray(mixed, np.float32)


def ambient_occlusion(picture: Picture, view: View, pixels: NDArray[np.int64]) -> NDArray[np.float32]:
    """How much light reaches pixels past what is in front of them, (p,), 0 to 1.

    The surroundings are blurred at half the resolution, as they have no detail.
    """
    height, width = picture.depth.shape
    depth = picture.depth.ravel()[pixels]
    filled = np.full((height, width), depth.min(initial=np.inf), np.float32)
    filled.ravel()[pixels] = depth
    darkness = np.zeros_like(depth)
    for radius, rate in CREVICES:
        reach = max(1, round(radius * view.height * view.samples / view.span / 2))
        around = double_rows(double_rows(blur(filled[::2, ::2], reach)).T).T[:height, :width]
        row, column = np.divmod(pixels, width)
        darkness += np.float32(rate) * np.maximum(around[row, column] - depth, 0)
    return np.asarray(np.exp(-darkness), np.float32)


def double_rows(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Twice as many rows, the new ones halfway between their neighbours; the last one repeats."""
    after = np.concatenate([values[1:], values[-1:]])
    return np.stack([values, (values + after) / 2], axis=1).reshape(-1, values.shape[1])


def blur(values: NDArray[np.float32], radius: int) -> NDArray[np.float32]:
    """Mean over a square of (2·radius + 1)² pixels, twice; the border repeats."""
    for axis in (0, 1, 0, 1):
        padded = np.pad(values, [(radius, radius) if a == axis else (0, 0) for a in (0, 1)], mode="edge")
        padded, count = (padded, len(values)) if axis == 0 else (padded.T, values.shape[1])
        sums = padded[:count].copy()
        for shift in range(1, 2 * radius + 1):
            sums += padded[shift : shift + count]
        values = (sums if axis == 0 else sums.T) / np.float32(2 * radius + 1)
    return values


@cache
def backdrop(height: int, width: int) -> NDArray[np.float32]:
    """A soft background gradient, (height, width, 3) linear."""
    share = np.linspace(1, 0, height, dtype=np.float32)[:, None, None]
    low, high = np.array(BACKDROP, np.float32)
    return np.asarray(np.broadcast_to(low + share * (high - low), (height, width, 3)), np.float32)


def downsample(image: NDArray[np.float32], samples: int) -> NDArray[np.float32]:
    """Average squares of samples (anti-aliasing)."""
    height, width = image.shape[0] // samples, image.shape[1] // samples
    return np.asarray(image.reshape(height, samples, width, samples, 3).mean(axis=(1, 3)), np.float32)


def soften_edges(image: NDArray[np.float32], depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Smooth the picture in place: a mean of five pixels at edges between near and far surfaces."""
    known = np.maximum(depth, -OUTLINE * 10)
    edges = np.zeros(depth.shape, bool)
    edges[:-1] |= np.abs(np.diff(known, axis=0)) > OUTLINE
    edges[:, :-1] |= np.abs(np.diff(known, axis=1)) > OUTLINE
    edges[1:] |= edges[:-1].copy()
    edges[:, 1:] |= edges[:, :-1].copy()
    rows, columns = np.nonzero(edges)
    last = (depth.shape[0] - 1, depth.shape[1] - 1)
    near = [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)]
    sums = sum(image[np.clip(rows + y, 0, last[0]), np.clip(columns + x, 0, last[1])] for y, x in near)
    image[rows, columns] = sums / np.float32(len(near))
    return image


def to_srgb(linear: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Linear light as sRGB bytes (IEC 61966-2-1), highlights compressed softly."""
    steps = (linear * np.float32(TONE_STEPS)).astype(np.int32)
    return np.asarray(_tones().take(steps, mode="clip"), np.uint8)


@cache
def _tones() -> NDArray[np.uint8]:
    """The byte for each step of light; a table is ten times as fast as computing powers."""
    linear = (np.arange(TONE_LIMIT * TONE_STEPS) + 0.5) / TONE_STEPS
    soft = np.where(linear > SHOULDER, SHOULDER + 0.4 * np.tanh((linear - SHOULDER) / 0.4), linear)
    encoded = np.where(soft <= 0.0031308, 12.92 * soft, 1.055 * soft ** (1 / 2.4) - 0.055)
    return np.asarray(np.rint(np.clip(encoded, 0, 1) * 255), np.uint8)


def vertex_normals(points: NDArray[np.float32], triangles: NDArray[np.int64]) -> NDArray[np.float32]:
    """Unit normals, weighted by area, (n, 3)."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    flat = triangles.T.ravel()
    sums = np.stack([np.bincount(flat, np.tile(f, 3), len(points)) for f in faces.T], axis=1)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.asarray(sums / np.maximum(lengths, 1e-12), np.float32)


def normalized(vector: tuple[float, ...] | NDArray[np.float32]) -> NDArray[np.float32]:
    """The unit vector."""
    values = np.asarray(vector, np.float32)
    return np.asarray(values / np.linalg.norm(values), np.float32)
