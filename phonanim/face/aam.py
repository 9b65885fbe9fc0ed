"""Find a known face in pictures: an active appearance model, fitted by inverse compositional search."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.search import first_guesses
from phonanim.face.appearance import LUMA, AppearanceModel, flat_points
from phonanim.face.warp import Mesh, sample_bilinear

Array = NDArray[np.float64]
Grey = NDArray[np.float32]

N_SIMILARITY = 4  # scale, roll, right, down
TURN_STD = 0.05  # radians: standard deviation of the turns of a talking head
STEPS, CLOSE = 30, 0.02  # maximum number of iterations, and the move in texture pixels that ends them
LARGEST_GROWTH, LARGEST_SHAPE = 1.5, 10.0  # within one search; standard deviations
RIDGE = 1e-6
FAINT = 0.1  # of the template's contrast: a picture with less contrast has no face


@dataclass(frozen=True)
class Options:
    """Weights of the search between pixels and prior; chosen on training clips (docs/appearance.md).

    `outer` and `inner` are how many appearance modes are projected out, `noise` the standard deviation of a
    pixel in grey levels, `likeness` the least share of a picture's contrast that the model must explain for a
    frame to count as found.
    """

    outer: int = 5
    inner: int = 5
    noise: float = 40.0
    likeness: float = 0.9


@dataclass(frozen=True)
class Pose:
    """One fit: `similarity` (4,) scale·cos, scale·sin, right, down in pixels, `shape` (m + 2,) in deviations.

    The last two of `shape` turn the head to the side and down. `likeness` 0 to 1 is the share of the
    picture's contrast that the model explains.
    """

    similarity: Array
    shape: Array
    likeness: float = 0.0


@dataclass(frozen=True)
class Fitter:
    """The parts of the search that do not depend on the picture (Matthews and Baker 2004, section 4).

    `base` (n, 2) is the centred reference in texture pixels, `modes` (k, n, 2) its change by one deviation of
    each shape parameter, `start` (k,) the parameters of the reference. `template` (p,) and `basis` (a, p) are
    the grey mean and the modes that are projected out, `steepest` (4 + k, p) the descent images without them,
    `hessian` (4 + k, 4 + k). `inverse_edges` (t, 2, 2) and `around` (n, t) are used to compose warps.
    """

    model: AppearanceModel
    options: Options
    base: Array
    modes: Array
    start: Array
    template: Grey
    basis: Grey
    steepest: Grey
    hessian: Array
    inverse_edges: Array
    around: Array

    def points(self, pose: Pose) -> Array:
        """The mesh's landmarks in a picture, (n, 2) pixels."""
        return _placed(self.base + np.tensordot(pose.shape - self.start, self.modes, 1), pose.similarity)

    def landmarks(self, pose: Pose) -> Array:
        """All landmarks of the face, (landmarks, 3) pixels right and down, and away from the camera."""
        n_modes = len(self.model.face.std)
        shape = self.model.face.instance(pose.shape[None, :n_modes] * self.model.face.std)[0]
        yaw, pitch = pose.shape[n_modes:] * TURN_STD
        x, y, z = (shape - shape_pivot(self.model)).T
        turned = np.column_stack([x + yaw * z, y - pitch * z, z - yaw * x + pitch * y])
        flat = flat_points(turned, self.model.pixel) - self._offset
        depth = -turned[:, 2] / self.model.pixel * _scale(pose)
        return np.column_stack([_placed(flat, pose.similarity), depth])

    def fit(self, image: Grey, pose: Pose) -> Pose:
        """Improve a pose on a grey picture (rows, columns) until it converges; likeness 0 if it diverges."""
        first = pose = replace(pose, likeness=0.0)
        for _ in range(STEPS):
            moved = self._compose(pose, self._change(self._error(image, pose), pose))
            if _ran_away(moved, first):
                return first
            distance = np.abs(self.points(moved) - self.points(pose)).max() / _scale(pose)
            pose = moved
            if distance < CLOSE:
                break
        return replace(pose, likeness=self.likeness(image, pose))

    def likeness(self, image: Grey, pose: Pose) -> float:
        """Share of the picture's contrast under the mesh that the model explains, 0 to 1."""
        texture = self._texture(image, pose)
        if texture.std() < FAINT * self.template.std():
            return 0.0
        texture = texture - texture.mean()
        left = texture - (self.basis @ texture) @ self.basis
        return float(1 - (left**2).sum() / max(float((texture**2).sum()), 1e-9))

    def _texture(self, image: Grey, pose: Pose) -> Grey:
        places = self.model.mesh.places(self.points(pose)[None])[0]
        return sample_bilinear(image[..., None], places)[:, 0]

    def _error(self, image: Grey, pose: Pose) -> Grey:
        """Picture minus template, after the picture's gain and offset are matched to the template's."""
        texture = self._texture(image, pose)
        spread = max(float(texture.std()), 1e-3)
        aligned = (texture - texture.mean()) * (self.template.std() / spread) + self.template.mean()
        return np.asarray(aligned - self.template, np.float32)

    def _change(self, error: Grey, pose: Pose) -> Array:
        """The step in the template's frame: Gauss-Newton with a normal prior on the shape, (4 + k,)."""
        prior = np.concatenate([np.zeros(N_SIMILARITY), np.full(len(pose.shape), self.options.noise**2)])
        pull = np.concatenate([np.zeros(N_SIMILARITY), pose.shape])
        return np.linalg.solve(self.hessian + np.diag(prior), self.steepest @ error + prior * pull)

    def _compose(self, pose: Pose, change: Array) -> Pose:
        """The warp after the inverse of a small one (section 4.2): moved corners, then the nearest pose."""
        moved = np.tensordot(change, _directions(self.base, self.modes), 1)
        points = self.points(pose)
        affine = np.einsum("tij,tjk->tik", _edges(points, self.model.mesh), self.inverse_edges)
        local = (self.around @ affine.reshape(len(affine), 4)).reshape(-1, 2, 2)
        target = points - np.einsum("nij,nj->ni", local, moved)
        return self._nearest(target, pose)

    def _nearest(self, target: Array, pose: Pose) -> Pose:
        """The pose whose corners are nearest to the given ones, by one Gauss-Newton step, (n, 2)."""
        plain = self.base + np.tensordot(pose.shape - self.start, self.modes, 1)
        turn = np.array([pose.similarity[:2], [-pose.similarity[1], pose.similarity[0]]])
        directions = _directions(plain, self.modes @ turn).reshape(N_SIMILARITY + len(self.modes), -1)
        normal = directions @ directions.T
        normal += np.diag(RIDGE * np.diag(normal))
        step = np.linalg.solve(normal, directions @ (target - self.points(pose)).ravel())
        return Pose(pose.similarity + step[:N_SIMILARITY], pose.shape + step[N_SIMILARITY:])

    @property
    def _offset(self) -> Array:
        """From millimetre axes in texture pixels to the centred reference."""
        model = self.model
        rest = model.face.instance(self.start[None, : len(model.face.std)] * model.face.std)[0] - shape_pivot(
            model
        )
        return np.asarray((flat_points(rest[model.rows], model.pixel) - self.base).mean(axis=0))


def shape_pivot(model: AppearanceModel) -> Array:
    """The point about which the head turns in the search, (3,) mm: the middle of the mesh's landmarks."""
    return np.asarray(model.face.mean[model.rows].mean(axis=0))


def build_fitter(model: AppearanceModel, options: Options = Options()) -> Fitter:
    """Prepare the search for a face."""
    mesh, face = model.mesh, model.face
    base = mesh.reference - mesh.reference.mean(axis=0)
    deep = (face.mean - shape_pivot(model))[model.rows, 2] * TURN_STD / model.pixel
    turns = np.zeros((2, len(base), 2))
    turns[0, :, 0], turns[1, :, 1] = deep, deep
    shape = flat_points(face.modes[:, model.rows] * face.std[:, None, None], model.pixel)
    modes = np.concatenate([shape, turns])
    start = np.zeros(len(modes))
    start[0] = 1.0
    template = model.mean_texture @ LUMA
    basis = grey_basis(model, template, options)
    slope = _slopes(mesh, template)
    moves = np.stack([mesh.places(d[None])[0] for d in _directions(base, modes)])
    steepest = np.einsum("kpc,pc->kp", moves, slope).astype(np.float32)
    steepest -= (steepest @ basis.T) @ basis
    hessian = (steepest @ steepest.T).astype(np.float64)
    edges = np.asarray(np.linalg.inv(_edges(base, mesh)), np.float64)
    around = (mesh.triangles[None] == np.arange(len(base))[:, None, None]).any(axis=2).astype(float)
    around /= around.sum(axis=1, keepdims=True)
    return Fitter(model, options, base, modes, start, template, basis, steepest, hessian, edges, around)


def grey_basis(model: AppearanceModel, template: Grey, options: Options) -> Grey:
    """Orthonormal grey pictures without shape information: appearance modes, gain, offset, (a, p)."""
    parts = [np.ones_like(template), template]
    for region, count in ((model.outer, options.outer), (model.inner, options.inner)):
        for mode in region.modes[:count]:
            picture = np.zeros_like(template)
            picture[region.place] = mode @ LUMA
            parts.append(picture)
    return np.ascontiguousarray(np.linalg.qr(np.array(parts, np.float64).T)[0].T, np.float32)


def track_face(fitter: Fitter, images: Iterable[NDArray[np.uint8]]) -> Iterator[Pose | None]:
    """Track the face through pictures (rows, columns, 3); None where it is not found.

    Each search starts from the frame before. At the first frame, and after a frame without a face, it starts
    from the best of many positions and sizes (`first_guesses`).
    """
    last: Pose | None = None
    for image in images:
        grey = image.astype(np.float32) @ LUMA
        found = fitter.fit(grey, last) if last else None
        if found is None or found.likeness < fitter.options.likeness:
            found = find_face(fitter, grey)
        last = found if found.likeness >= fitter.options.likeness else None
        yield last


def find_face(fitter: Fitter, image: Grey) -> Pose:
    """The best fit from many positions and sizes."""
    mean = fitter.model.mesh.picture(fitter.template[:, None])[..., 0]
    mask = fitter.model.mesh.picture(np.ones((len(fitter.template), 1)))[..., 0]
    middle = fitter.model.mesh.reference.mean(axis=0)
    tries = []
    for scale, corner in first_guesses(image, mean, mask):
        similarity = np.array([scale, 0.0, *(corner + scale * middle)])
        tries.append(fitter.fit(image, Pose(similarity, np.zeros_like(fitter.start))))
    return max(tries, key=lambda pose: pose.likeness)


def _scale(pose: Pose) -> float:
    return float(np.hypot(*pose.similarity[:2]))


def _ran_away(pose: Pose, first: Pose) -> bool:
    """Whether a search has diverged: it grew or shrank by a half, or its shape is impossible."""
    growth = _scale(pose) / _scale(first)
    return not (1 / LARGEST_GROWTH < growth < LARGEST_GROWTH and np.abs(pose.shape).max() < LARGEST_SHAPE)


def _directions(points: Array, modes: Array) -> Array:
    """The move of corners at (n, 2) by each parameter: scale, roll, right, down, the modes, (4 + k, n, 2)."""
    x, y = points.T
    zero, one = np.zeros_like(x), np.ones_like(x)
    similar = [(x, y), (-y, x), (one, zero), (zero, one)]
    return np.concatenate([np.array(similar).transpose(0, 2, 1), modes])


def _placed(points: Array, similarity: Array) -> Array:
    """Centred texture pixels (n, 2) in a picture."""
    turn = np.array([similarity[:2], [-similarity[1], similarity[0]]])
    return np.asarray(points @ turn + similarity[2:])


def _edges(points: Array, mesh: Mesh) -> Array:
    """Two edges of each triangle as columns, (t, 2, 2)."""
    a, b, c = (points[mesh.triangles[:, k]] for k in range(3))
    return np.stack([b - a, c - a], axis=2)


def _slopes(mesh: Mesh, texture: Grey) -> Array:
    """Gradient of a texture at its pixels, levels per pixel right and down, (p, 2); 0 at the border."""
    image = np.full(mesh.height * mesh.width, np.nan)
    image[mesh.pixels] = texture
    down, right = np.gradient(image.reshape(mesh.height, mesh.width))
    slopes: Any = np.column_stack([right.ravel(), down.ravel()])[mesh.pixels]
    return np.nan_to_num(slopes)
