"""How a skin follows the model's triangles: deformation transfer (Sumner and Popović 2004).

A shape rotates and stretches each triangle of the model. Each triangle of a skin should deform like its
corresponding model triangle, and the solver finds the vertices that fit this best. In the gradient form of
Botsch, Sumner, Pauly and Gross 2006 ("Deformation transfer for detail-preserving surface editing") this is
one Poisson system for all shapes, factorized once. Gradients alone drift: an error in a few triangles at a
rim moves the whole chin. So each vertex is also weakly pulled to the position given by the model's motion,
and facing points of the lips part as the model's do; otherwise closed lips would not stay closed.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.rig.align import NORMAL_REACH, Surface, scipy_parts
from phonanim.rig.geometry import face_normals, vertex_normals, weld
from phonanim.rig.head import Head
from phonanim.rig.landmarks import MeshLandmarks
from phonanim.rig.register import SAMPLE_WEIGHTS, sample_surface
from phonanim.rig.rims import LOWER_INNER, UPPER_INNER

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

FAR = 0.008  # metres: beyond this distance from the warped model there is no correspondence
TURNED = 0.3  # cosine of normals: below this there is no correspondence
STILL = 5e-5  # metres: points that the model moves less are held in place
HOLD, DRIFT = 1e-3, 1e-7  # weight of rest against gradients, where the model rests and where it moves
LOOSE = 0.1  # weight of a triangle without correspondence: it should not stiffen its neighbours
REACH = 0.018  # metres: beyond this, the position from the model's motion counts more than gradients
PARTING = 10.0  # weight of the lips' distance against gradients


class Deformation:
    """The Poisson system of a skin: from a shape's effect on the model's triangles to the skin's vertices."""

    def __init__(
        self, model: Head, spots: MeshLandmarks, warped: Surface, theirs: Surface, found: MeshLandmarks
    ) -> None:
        """Match triangles, vertices and lips, and factorize."""
        sparse, factorized, _ = scipy_parts()
        self.model, self.theirs = model, theirs
        self.triangles = warped.triangles
        self.rest = np.linalg.inv(_frames(model.vertices, self.triangles))
        find = Finder(warped)
        middles = theirs.points[theirs.triangles].mean(axis=1)
        self.owner, _, self.matched = find(middles, face_normals(theirs.points, theirs.triangles))
        self.welded, self.place = weld(theirs.points, theirs.triangles)
        self.points = theirs.points[self.welded]
        facing = vertex_normals(theirs.points, theirs.triangles)[self.welded]
        nearest, self.within, carried = find(self.points, facing)
        self.near = self.triangles[nearest]
        self.gradient, self.normals, areas = _gradient(theirs, self.place, len(self.welded), sparse)
        counts = areas * np.where(self.matched, 1.0, LOOSE)
        self.weighted = self.gradient.T @ sparse.diags(np.repeat(counts, 3))
        self.hold = self._holds()
        self.pull = carried * self._shares(areas) / REACH**2
        self.parting = _parting(spots, np.arange(len(model.vertices)), len(model.vertices), sparse)
        self.lips = _parting(found, self.place, len(self.welded), sparse)
        held = sparse.diags(self.hold + self.pull) + PARTING * self.lips.T @ self.lips
        self.solve = factorized((self.weighted @ self.gradient + held).tocsc())

    @property
    def matched_share(self) -> float:
        """The share of the skin's triangles that correspond to one of the model's."""
        return float(self.matched.mean())

    def _holds(self) -> Array:
        """How firmly each vertex is held: vertices that the model moves in no shape stay."""
        moved = np.linalg.norm(self.model.deltas, axis=2).max(axis=0)[self.triangles].max(axis=1)
        own = np.where(self.matched, moved[self.owner], 0.0)
        most = np.zeros(len(self.welded))
        np.maximum.at(most, self.place[self.theirs.triangles], own[:, None])
        return np.where(most < STILL, HOLD, DRIFT)

    def _shares(self, areas: Array) -> Array:
        """The area of each vertex, in square metres."""
        corners = self.place[self.theirs.triangles]
        shares = np.bincount(corners.ravel(), np.repeat(areas / 3, 3), minlength=len(self.welded))
        return np.asarray(shares, np.float64)

    def shape(self, delta: Array) -> Array:
        """One shape of the model on the skin, (model vertices, 3) -> (vertices, 3) metres."""
        turns = np.tile(np.eye(3), (len(self.matched), 1, 1))
        changed = _frames(self.model.vertices + delta, self.triangles) @ self.rest
        turns[self.matched] = changed[self.owner[self.matched]]
        tangent = np.eye(3) - np.einsum("ti,tj->tij", self.normals, self.normals)
        wanted = np.einsum("tij,tkj->tik", tangent, turns).reshape(-1, 3)
        carried = self.points + np.einsum("vk,vkj->vj", self.within, delta[self.near])
        parted = self.lips @ self.points + self.parting @ delta
        right = self.weighted @ wanted + self.hold[:, None] * self.points + self.pull[:, None] * carried
        right += PARTING * self.lips.T @ parted
        solved = np.column_stack([self.solve(column) for column in right.T])
        moved = np.zeros_like(self.theirs.points)
        used = self.place >= 0
        moved[used] = (solved - self.points)[self.place[used]]
        return moved


class Finder:
    """Find the nearest point of a warped model, by position and direction."""

    def __init__(self, warped: Surface) -> None:
        """Place samples on the surface."""
        _, _, tree = scipy_parts()
        self.points, _, self.owners = sample_surface(warped)
        self.facing = face_normals(warped.points, warped.triangles)[self.owners]
        self.search = tree(np.column_stack([self.points, NORMAL_REACH * self.facing]))

    def __call__(self, points: Array, facing: Array) -> tuple[Rows, Array, NDArray[np.bool_]]:
        """Triangles (n,), weights of their corners (n, 3), and whether they are near enough (n,)."""
        nearest = self.search.query(np.column_stack([points, NORMAL_REACH * facing]))[1]
        near = np.linalg.norm(self.points[nearest] - points, axis=1) < FAR
        near &= (self.facing[nearest] * facing).sum(axis=1) > TURNED
        return self.owners[nearest], SAMPLE_WEIGHTS[nearest % len(SAMPLE_WEIGHTS)], near


def _frames(points: Array, triangles: Rows) -> Array:
    """Two edges and the scaled normal of each triangle as columns (Sumner 2004, equation 3), (t, 3, 3)."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.sqrt(np.linalg.norm(normal, axis=1, keepdims=True)).clip(1e-12)
    return np.stack([b - a, c - a, normal], axis=2)


def _parting(landmarks: MeshLandmarks, place: Rows, count: int, sparse: Any) -> Any:
    """The upper lip's points minus the lower lip's facing points, (pairs, count)."""
    upper, lower = landmarks.take(UPPER_INNER), landmarks.take(LOWER_INNER)
    columns = place[np.concatenate([upper.corners, lower.corners], axis=1)]
    entries = np.concatenate([upper.weights, -lower.weights], axis=1)
    rows = np.repeat(np.arange(len(columns)), 6)
    return sparse.csr_matrix((entries.ravel(), (rows, columns.ravel())), shape=(len(columns), count))


def _gradient(surface: Surface, place: Rows, count: int, sparse: Any) -> tuple[Any, Array, Array]:
    """The gradient operator on triangles (3t, count), normals and areas."""
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    double = np.linalg.norm(np.cross(b - a, c - a), axis=1).clip(1e-14)
    normal = face_normals(surface.points, surface.triangles)
    slopes = [np.cross(normal, edge) / double[:, None] for edge in (c - b, a - c, b - a)]
    rows = np.tile(np.arange(3 * len(double)), 3)
    columns = np.concatenate([np.repeat(place[surface.triangles[:, k]], 3) for k in range(3)])
    entries = np.concatenate([slope.ravel() for slope in slopes])
    return sparse.csr_matrix((entries, (rows, columns)), shape=(3 * len(double), count)), normal, double / 2
