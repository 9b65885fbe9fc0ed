"""Turn back the triangles that a shape turns over, with the least change around them.

A projective scheme (Bouaziz et al. 2012, "Shape-Up: shaping discrete geometry with projections"): each turned
triangle is projected to the nearest orientation that is not turned over. The vertices around it should keep
their motion. A least-squares solve combines both, repeatedly. Needs scipy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.rig.align import scipy_parts
from phonanim.rig.geometry import face_normals, uniform_laplacian, weld

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Mask = NDArray[np.bool_]

RINGS = (3, 6, 12)  # rings around a turned triangle in which vertices may move
STEPS = 120  # rounds of projection, per ring
UPRIGHT, ENOUGH = 0.10, 0.02  # cosine to the triangle at rest: the target, and what is accepted
FIRM = 10.0  # weight of a turned triangle against the motion around it
KEEP = 0.01  # weight of a vertex's own motion against smoothness


def unflip(points: Array, delta: Array, triangles: Rows) -> tuple[Array, int]:
    """Motion that turns no triangle over, and the number of triangles that it still turns over.

    (vertices, 3), (vertices, 3), (triangles, 3) -> (vertices, 3). A triangle is turned over when it faces
    away from its direction at rest.
    """
    facing = face_normals(points, triangles)
    turned = _uprightness(points + delta, triangles, facing) < 0
    if not turned.any():
        return delta, 0
    rows, place = weld(points, triangles)
    corners, still, moved = place[triangles], points[rows], delta[rows]
    for rings in RINGS:
        patch = _around(corners, turned, rings, len(rows))
        moved = _turned_back(still, moved, corners, facing, patch)
        turned = _uprightness(still + moved, corners, facing) < 0
        if not turned.any():
            break
    straight, used = delta.copy(), place >= 0
    straight[used] = moved[place[used]]
    return straight, int(turned.sum())


def _turned_back(still: Array, moved: Array, corners: Rows, facing: Array, patch: Mask) -> Array:
    """The motion with the triangles of a patch of vertices turned back, and all else unchanged."""
    sparse, factorized, _ = scipy_parts()
    own = patch[corners].any(axis=1)
    corners, facing = corners[own], facing[own]
    even = uniform_laplacian(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), len(still))[patch][:, patch]
    stay = even.T @ even + KEEP * sparse.identity(int(patch.sum()))
    edges = _edges(corners, len(still), sparse)
    active, start, moved = np.zeros(len(corners), bool), moved[patch], moved.copy()
    for _ in range(STEPS):
        upright = _uprightness(still + moved, corners, facing)
        if (upright > ENOUGH).all():
            break
        if (fresh := upright < ENOUGH)[~active].any():
            active |= fresh
            chosen = edges[np.repeat(active, 3)]
            inner = chosen[:, patch]
            solve = factorized((stay + FIRM * inner.T @ inner).tocsc())
        wanted = _righted(chosen @ (still + moved), upright[active], facing[active])
        rest = wanted - chosen @ still - chosen[:, ~patch] @ moved[~patch]
        moved[patch] = solve(stay @ start + FIRM * inner.T @ rest)
    return moved


def _uprightness(points: Array, corners: Rows, facing: Array) -> Array:
    """The cosine between each triangle's direction and its direction at rest, (triangles,)."""
    return np.asarray((face_normals(points, corners) * facing).sum(axis=1))


def _righted(edges: Array, upright: Array, facing: Array) -> Array:
    """Edges of triangles, (3 triangles, 3), rotated by the least amount that makes them face correctly."""
    edges = edges.reshape(-1, 3, 3)
    normal = np.cross(edges[:, 0], edges[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True).clip(1e-15)
    aside = normal - (normal * facing).sum(axis=1, keepdims=True) * facing
    longest = np.take_along_axis(edges, np.linalg.norm(edges, axis=2).argmax(axis=1)[:, None, None], axis=1)[
        :, 0
    ]
    spare = np.cross(longest, facing)
    aside = np.where(np.linalg.norm(aside, axis=1, keepdims=True) > 1e-3, aside, spare)
    aside /= np.linalg.norm(aside, axis=1, keepdims=True).clip(1e-15)
    cosine = np.maximum(upright, UPRIGHT)[:, None]
    goal = cosine * facing + np.sqrt(1 - cosine**2) * aside
    return np.einsum("tij,tkj->tki", _turns(normal, goal), edges).reshape(-1, 3)


def _turns(one: Array, other: Array) -> Array:
    """The least rotations that turn directions into others, (n, 3), (n, 3) -> (n, 3, 3)."""
    axis, cosine = np.cross(one, other), (one * other).sum(axis=1)[:, None, None]
    cross = np.cross(axis[:, None, :], np.eye(3)[None]).transpose(0, 2, 1)
    return np.asarray(np.eye(3) + cross + cross @ cross / (1 + cosine).clip(1e-6))


def _around(corners: Rows, turned: Mask, rings: int, count: int) -> Mask:
    """The vertices within some rings of turned triangles, (count,)."""
    patch = np.zeros(count, bool)
    patch[corners[turned]] = True
    for _ in range(rings):
        patch[corners[patch[corners].any(axis=1)]] = True
    return patch


def _edges(corners: Rows, count: int, sparse: Any) -> Any:
    """The three edges of each triangle as differences of vertices, (3 triangles, count)."""
    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
    signs = np.tile((-1.0, 1.0), len(ends))
    places = (np.repeat(np.arange(len(ends)), 2), ends.ravel())
    return sparse.csr_matrix((signs, places), shape=(len(ends), count))
