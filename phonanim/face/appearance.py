"""Appearance model of the reference face (AAM): shape, appearance and joint modes."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE, read_json, read_tensors
from phonanim.core.files import atomic_path, write_text
from phonanim.core.version import __version__
from phonanim.errors import ModelError
from phonanim.face.model import INNER_LIPS, FaceModel
from phonanim.face.warp import Mesh, build_mesh

Array = NDArray[np.float64]
Texture = NDArray[np.float32]

FORMAT = 1
NOSE_RIDGE = 5  # highest landmark of the picture, which has the mouth, the jaw and the (rigid) nose tip
OPENED = 1.0  # standard deviations of the first mode: a reference shape with space for teeth and tongue
LUMA = np.array([0.299, 0.587, 0.114], np.float32)  # ITU-R BT.601
BACKDROP = (24, 26, 31)


@dataclass(frozen=True)
class Region:
    """Pixels that vary together: A = mean + sum_k c_k modes_k (Cootes, Edwards and Taylor 2001).

    `place` (r,) are rows of the texture, `mean` (r, 3) sRGB levels 0 to 255, `modes` (n, r, 3)
    orthonormal and largest first, `std` (n,) levels.
    """

    place: NDArray[np.int64]
    mean: Texture
    modes: Texture
    std: Array

    def project(self, textures: Texture) -> Array:
        """Parameters of whole textures, (frames, p, 3) -> (frames, n)."""
        flat = (textures[:, self.place] - self.mean).reshape(len(textures), -1)
        return np.asarray(flat @ self.modes.reshape(len(self.modes), -1).T, np.float64)

    def instance(self, parameters: NDArray[np.floating]) -> Texture:
        """The region's part of textures, (frames, n) -> (frames, r, 3)."""
        flat = parameters.astype(np.float32) @ self.modes.reshape(len(self.modes), -1)
        return np.asarray(self.mean + flat.reshape(-1, *self.mean.shape), np.float32)


@dataclass(frozen=True)
class AppearanceModel:
    """A face with its texture; every frame is j joint parameters (Taylor 2017, section 4.1, equation 1).

    `face` has the m shape modes, `mesh` the pixels between the landmarks `rows` of the face, `inner` the
    inside of the mouth and `outer` the rest of the lower face. `basis` (j, m + n_outer + n_inner) is
    orthonormal and acts on (weight · shape, outer, inner); `std` (j,) is in levels; `weight`, in levels per
    mm, makes the shape vary as much as the pixels. `slopes` (m, p, 3) is the change of a texture with the
    shape, in levels per mm; it separates the light of a clip from its speech. `pixel` is the size of a
    texture's pixels in mm.
    """

    face: FaceModel
    rows: NDArray[np.int64]
    mesh: Mesh
    outer: Region
    inner: Region
    slopes: Texture
    weight: float
    basis: Array
    std: Array
    pixel: float

    def project(self, shape_modes: NDArray[np.floating], textures: Texture) -> Array:
        """Joint parameters, from (frames, m) and textures (frames, p, 3) -> (frames, j).

        Textures come from `mesh.cut(images, landmarks)`, best after `without_light`.
        """
        parts = (self.weight * shape_modes, self.outer.project(textures), self.inner.project(textures))
        return np.asarray(np.concatenate(parts, axis=1) @ self.basis.T)

    def instance(self, joint: NDArray[np.floating]) -> tuple[Array, Texture]:
        """Shape modes (frames, m) and textures (frames, p, 3) of joint parameters (frames, j)."""
        parts = np.asarray(joint, np.float64) @ self.basis
        shape, outer, inner = np.split(parts, self._cuts, axis=1)
        return shape / self.weight, self.textures(outer, inner)

    def textures(self, outer: NDArray[np.floating], inner: NDArray[np.floating]) -> Texture:
        """Textures of both regions' parameters, (frames, n_outer), (frames, n_inner) -> (frames, p, 3)."""
        textures = np.empty((len(outer), len(self.mesh.pixels), 3), np.float32)
        textures[:, self.outer.place] = self.outer.instance(outer)
        textures[:, self.inner.place] = self.inner.instance(inner)
        return textures

    def without_light(self, textures: Texture, shape_modes: NDArray[np.floating]) -> Texture:
        """The textures of one clip in mean light, (frames, p, 3) with (frames, m) -> the same."""
        return without_light(textures, shape_modes, self.mean_texture, self.slopes)

    def render(self, joint: NDArray[np.floating], scale: float = 2.0) -> NDArray[np.uint8]:
        """Mouth pictures of joint parameters (frames, j) -> (frames, rows, columns, 3), even sizes.

        Seen from the front, `scale` times as large as the reference.
        """
        shape_modes, textures = self.instance(joint)
        return self.draw(self.face.instance(shape_modes), textures, scale)

    def draw(self, shapes: Array, textures: Texture, scale: float = 2.0) -> NDArray[np.uint8]:
        """Mouth pictures of shapes (frames, landmarks, 3) mm with textures (frames, p, 3)."""
        room = 4 * scale  # for a jaw below that of the reference
        points = flat_points(shapes[:, self.rows], self.pixel / scale) - self._corner(scale) + room
        size = (2 * int(v * scale / 2 + room + 1) for v in (self.mesh.height, self.mesh.width))
        canvas = np.full((*size, 3), BACKDROP, np.uint8)
        drawn = [self.mesh.draw(t, p, canvas) for t, p in zip(textures, points, strict=True)]
        return np.stack(drawn)

    @cached_property
    def mean_texture(self) -> Texture:
        """The mean picture, (p, 3) levels."""
        texture = np.empty((len(self.mesh.pixels), 3), np.float32)
        texture[self.outer.place], texture[self.inner.place] = self.outer.mean, self.inner.mean
        return texture

    @cached_property
    def _cuts(self) -> list[int]:
        return [len(self.face.std), len(self.face.std) + len(self.outer.std)]

    def _corner(self, scale: float) -> Array:
        reference = flat_points(reference_shape(self.face)[None, self.rows], self.pixel / scale)[0]
        return np.asarray((reference - self.mesh.reference * scale).mean(axis=0))


def without_light(
    textures: Texture, shape_modes: NDArray[np.floating], mean: Texture, slopes: Texture
) -> Texture:
    """The textures of one clip in mean light, (frames, p, 3) with (frames, m) -> the same.

    The mean picture of a clip minus the part that its mean shape explains is an effect of the lighting and
    the head position. It is not speech, so it is subtracted.
    """
    explained = np.tensordot(shape_modes.mean(axis=0).astype(np.float32), slopes, 1)
    return np.asarray(textures - (textures.mean(axis=0) - mean - explained), np.float32)


def flat_points(shapes: NDArray[np.floating], pixel: float) -> Array:
    """Shapes seen from the front, (frames, landmarks, 3) mm -> (frames, landmarks, 2) pixels right, down."""
    return np.asarray(shapes[..., :2] * np.array([1.0, -1.0]) / pixel)


def reference_shape(face: FaceModel) -> Array:
    """The shape in which textures are laid out, (landmarks, 3) mm: the mean with a slightly open mouth.

    In the mean shape itself, the inside of the mouth would be two pixels high.
    """
    return np.asarray(face.mean + OPENED * face.std[0] * face.modes[0])


def appearance_mesh(face: FaceModel, pixel: float) -> tuple[NDArray[np.int64], Mesh]:
    """The landmarks of the texture (rows of the face), and the mesh between them."""
    rows = np.flatnonzero(face.mean[:, 1] <= face.mean[face.landmark(NOSE_RIDGE), 1])
    return rows, build_mesh(flat_points(reference_shape(face)[rows], pixel))


def inner_mouth(face: FaceModel, rows: NDArray[np.int64], mesh: Mesh) -> NDArray[np.bool_]:
    """A mask of the pixels of a mesh in triangles between the inner lips, (p,)."""
    lips = np.searchsorted(rows, face.rows(INNER_LIPS))
    return np.asarray(np.isin(mesh.corners, lips).all(axis=1))


def fit_region(textures: Texture, place: NDArray[np.int64], variance: float) -> Region:
    """PCA of some pixels of textures, (frames, p, 3), that keeps a given share of the variance."""
    chosen = textures[:, place].reshape(len(textures), -1)
    mean = chosen.mean(axis=0, dtype=np.float64)
    modes, std = principal(chosen - mean.astype(np.float32), variance)
    shape = (len(place), 3)
    return Region(
        place, mean.reshape(shape).astype(np.float32), modes.reshape(-1, *shape).astype(np.float32), std
    )


def principal(centred: NDArray[np.floating], variance: float) -> tuple[Array, Array]:
    """Principal directions of centred samples (n, d) -> (k, d) orthonormal, and their deviations (k,).

    Each sign makes the largest entry positive. Computed by the smaller of the two Gram matrices.
    """
    n_samples, size = centred.shape
    wide = size > n_samples
    gram = (centred @ centred.T if wide else centred.T @ centred).astype(np.float64) / n_samples
    energy, vectors = np.linalg.eigh(gram)
    energy, vectors = np.maximum(energy[::-1], 0), vectors[:, ::-1]
    count = int(np.searchsorted(np.cumsum(energy), variance * energy.sum())) + 1
    count = min(count, int((energy > energy[0] * 1e-9).sum()))
    kept = vectors[:, :count]
    directions = (kept.T @ centred if wide else kept.T).astype(np.float64)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    largest = np.take_along_axis(directions, np.abs(directions).argmax(axis=1)[:, None], axis=1)
    return directions * np.where(largest < 0, -1.0, 1.0), np.sqrt(energy[:count])


def joint_weight(face: FaceModel, outer: Region, inner: Region) -> float:
    """Levels per mm: root of the pixels' total variance over the shape's (Cootes 2001, section 2)."""
    pixels = (outer.std**2).sum() + (inner.std**2).sum()
    return float(np.sqrt(pixels / (face.std**2).sum()))


def save_appearance(model: AppearanceModel, folder: Path, card: dict[str, Any]) -> None:
    """Write appearance.safetensors and, last, appearance.json into a folder."""
    from safetensors.numpy import save

    folder.mkdir(parents=True, exist_ok=True)
    with atomic_path(folder / "appearance.safetensors") as path:
        path.write_bytes(save({k: np.ascontiguousarray(v) for k, v in _tensors(model).items()}))
    facts = {
        "format": FORMAT,
        "tool": f"phonanim {__version__}",
        "face": model.face.id,
        "weight": model.weight,
        "pixel_mm": model.pixel,
        "grid": [model.mesh.height, model.mesh.width],
    }
    write_text(folder / "appearance.json", json.dumps(facts | card, indent=1) + "\n")


def load_appearance(folder: Path) -> AppearanceModel:
    """Read the output of `save_appearance`. Raises ModelError when it is missing or damaged."""
    try:
        facts = read_json(folder / "appearance.json")
        tensors = read_tensors(folder / "appearance.safetensors")
        if facts["format"] != FORMAT:
            raise ValueError(f"format {facts['format']}, not {FORMAT}")
        return _checked(_from_tensors(tensors, facts))
    except (OSError, *DAMAGE) as error:
        raise ModelError(
            f"{folder}: is not an appearance model ({error}); make one with `phonanim corpus appearance`"
        ) from error


def _checked(model: AppearanceModel) -> AppearanceModel:
    """The model itself. Raises ValueError when its parts do not match or are not finite."""
    n_parts = len(model.face.std) + len(model.outer.std) + len(model.inner.std)
    n_pixels, n_modes = len(model.mesh.pixels), len(model.face.std)
    agree = (
        model.basis.shape == (len(model.std), n_parts),
        model.slopes.shape == (n_modes, n_pixels, 3),
        model.mesh.corners.shape == model.mesh.weights.shape == (n_pixels, 3),
        len(model.outer.place) + len(model.inner.place) == n_pixels,
        len(model.rows) == len(model.mesh.reference) <= len(model.face.mean),
    )
    if not all(agree):
        raise ValueError("its shapes do not match")
    if not all(np.isfinite(part).all() for part in _tensors(model).values()):
        raise ValueError("it has numbers that are not finite")
    return model


def _tensors(model: AppearanceModel) -> dict[str, NDArray[Any]]:
    parts: dict[str, NDArray[Any]] = {"rows": model.rows, "slopes": model.slopes, "basis": model.basis}
    parts["std"] = model.std
    for name in ("mean", "modes", "std", "indices"):
        parts[f"face.{name}"] = getattr(model.face, name)
    for name in ("reference", "triangles", "pixels", "corners", "weights"):
        parts[f"mesh.{name}"] = getattr(model.mesh, name)
    for region in ("outer", "inner"):
        for name in ("place", "mean", "modes", "std"):
            parts[f"{region}.{name}"] = getattr(getattr(model, region), name)
    return parts


def _from_tensors(tensors: dict[str, NDArray[Any]], facts: dict[str, Any]) -> AppearanceModel:
    face = FaceModel(*(tensors[f"face.{name}"] for name in ("mean", "modes", "std", "indices")))
    reference, triangles = tensors["mesh.reference"], tensors["mesh.triangles"]
    spots = (tensors[f"mesh.{name}"] for name in ("pixels", "corners", "weights"))
    height, width = facts["grid"]
    outer, inner = (
        Region(*(tensors[f"{region}.{name}"] for name in ("place", "mean", "modes", "std")))
        for region in ("outer", "inner")
    )
    return AppearanceModel(
        face=face,
        rows=tensors["rows"],
        mesh=Mesh(reference, triangles, height, width, *spots),
        outer=outer,
        inner=inner,
        slopes=tensors["slopes"],
        weight=facts["weight"],
        basis=tensors["basis"],
        std=tensors["std"],
        pixel=facts["pixel_mm"],
    )
