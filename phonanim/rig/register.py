"""Find the shipped head's points on another head: alignment, then a smooth warp onto its surface.

The warp is that of Amberg, Romdhani and Vetter 2007 ("Optimal step nonrigid ICP algorithms for surface
registration"), with a displacement per vertex held smooth by the graph Laplacian, and its stiffness
lowered step by step. Needs scipy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.rig.align import Surface, align_heads, face_rows, known_places, scipy_parts, surface_of
from phonanim.rig.geometry import uniform_laplacian
from phonanim.rig.head import Head
from phonanim.rig.landmarks import MeshLandmarks
from phonanim.rig.rims import put_on_rims

Array = NDArray[np.float64]

STIFFNESS = (50.0, 20.0, 8.0, 3.0, 1.0, 0.4)
CORNERS = (61, 291)  # landmarks at the corners of the mouth
LIPS = 0.025  # metres from the middle of the mouth within which lips are told apart by how they open
BEND = 0.06  # metres within which proportions change together
TRUST = 0.3  # the greater, the less a single shape bends the face
STEPS = 4  # per stiffness
PIN = 20.0  # weight of a pinned point relative to a surface point
# Sample positions on a triangle: corners, middles of edges, the centre, halfway to each corner.
SAMPLES = np.concatenate([np.eye(3), 1 - np.eye(3), np.ones((1, 3)), np.ones((3, 3)) + 3 * np.eye(3)])
SAMPLE_WEIGHTS = SAMPLES / SAMPLES.sum(axis=1, keepdims=True)


@dataclass(frozen=True)
class Pins:
    """Points of a surface that must reach known positions, (pins, 3) metres."""

    spots: MeshLandmarks
    goals: Array


def suggest_landmarks(model: Head, spots: MeshLandmarks, target: Head) -> MeshLandmarks:
    """The model's landmarks on another head with blendshapes, in any units and axes.

    Raises RigError when the heads cannot be aligned, MissingExtraError without scipy.
    """
    mine, theirs = surface_of(model), surface_of(target)
    if not theirs.opening.any():
        mine = replace(mine, opening=np.zeros_like(mine.opening))
    aligned = align_heads(model, target)
    theirs = replace(theirs, points=aligned(target.vertices))
    mine = replace(mine, points=bent_points(mine.points, *known_places(model, target), aligned))
    mouth = spots.take(CORNERS).of(mine.points).mean(axis=0)
    mine, theirs = (opening_near(surface, mouth) for surface in (mine, theirs))
    warped = warp_surface(mine, theirs, face_rows(model, spots))
    return place_landmarks(warped, spots, theirs)


def opening_near(surface: Surface, mouth: Array) -> Surface:
    """A surface whose motion as the mouth opens counts near the mouth alone.

    What opens a mouth moves a chin on some heads, and the lower lip alone on others.
    """
    apart = np.linalg.norm(surface.points - mouth, axis=1)
    return replace(surface, opening=surface.opening * np.exp(-((apart / LIPS) ** 2) / 2))


def bent_points(points: Array, ours: Array, theirs: Array, aligned: Callable[[Array], Array]) -> Array:
    """Points moved as what the shapes of the same names move has moved, smoothly: other proportions."""
    moves = aligned(theirs) - ours
    gaps = np.linalg.norm(ours[:, None] - ours[None], axis=2)
    kernel = np.exp(-((gaps / BEND) ** 2) / 2)
    forces = np.linalg.solve(kernel + TRUST * np.eye(len(ours)), moves - moves.mean(axis=0))
    apart = np.linalg.norm(points[:, None] - ours[None], axis=2)
    return np.asarray(points + moves.mean(axis=0) + np.exp(-((apart / BEND) ** 2) / 2) @ forces)


def warp_surface(
    mine: Surface, theirs: Surface, rows: NDArray[np.int64], pins: Pins | None = None
) -> Surface:
    """Warp some points of one surface smoothly onto another, with `pins` at their positions."""
    sparse, factorized, tree = scipy_parts()
    goal_points, goal_features, _ = sample_surface(theirs)
    search = tree(goal_features)
    smooth = _laplacian(mine.triangles, rows)
    smooth = smooth.T @ smooth
    start, points = mine.points[rows], mine.points.copy()
    held, pull = _held(pins, rows, start, sparse)
    for stiffness in STIFFNESS:
        solve = factorized((held + stiffness * smooth).tocsc())
        for _ in range(STEPS):
            features = replace(mine, points=points).features()[rows]
            goals = goal_points[search.query(features)[1]]
            points[rows] = start + solve(goals - start + pull)
    return replace(mine, points=points)


def _held(pins: Pins | None, rows: NDArray[np.int64], start: Array, sparse: Any) -> tuple[Any, Array]:
    """The weights of point goals and pins, (rows, rows), and the pull of the pins (rows, 3)."""
    held, pull = sparse.identity(len(rows), format="csr"), np.zeros_like(start)
    if pins is None:
        return held, pull
    place = {int(row): number for number, row in enumerate(rows)}
    inside = np.array([all(int(corner) in place for corner in corners) for corners in pins.spots.corners])
    corners = np.array([[place[int(c)] for c in triple] for triple in pins.spots.corners[inside]])
    weights = pins.spots.weights[inside]
    entries = (weights.ravel(), (np.repeat(np.arange(len(corners)), 3), corners.ravel()))
    blend = sparse.csr_matrix(entries, shape=(len(corners), len(rows)))
    return held + PIN * blend.T @ blend, PIN * blend.T @ (pins.goals[inside] - blend @ start)


def _laplacian(triangles: NDArray[np.int64], rows: NDArray[np.int64]) -> Any:
    """The Laplacian of the edges between these rows alone, sparse (rows, rows)."""
    place = np.full(int(triangles.max()) + 1, -1)
    place[rows] = np.arange(len(rows))
    edges = place[triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)]
    return uniform_laplacian(edges[(edges >= 0).all(axis=1)], len(rows))


def sample_surface(surface: Surface) -> tuple[Array, Array, NDArray[np.int64]]:
    """Points spread over the triangles with their features, (samples, 3), (samples, 7), and triangles."""
    weights = SAMPLE_WEIGHTS
    features = np.einsum("sk,tkf->tsf", weights, surface.features()[surface.triangles])
    points = np.einsum("sk,tkf->tsf", weights, surface.points[surface.triangles])
    owners = np.repeat(np.arange(len(surface.triangles)), len(weights))
    return points.reshape(-1, 3), features.reshape(-1, features.shape[2]), owners


def place_landmarks(warped: Surface, spots: MeshLandmarks, theirs: Surface) -> MeshLandmarks:
    """Landmarks of the warped model at the nearest points of the other surface, inner lips on its rims."""
    _, _, tree = scipy_parts()
    _, features, owners = sample_surface(theirs)
    found = tree(features).query(spots.of(warped.features()))[1]
    weights = SAMPLE_WEIGHTS[found % len(SAMPLE_WEIGHTS)]
    placed = MeshLandmarks(spots.numbers, theirs.triangles[owners[found]], weights)
    opening = theirs.opening if theirs.opening.any() else None
    return put_on_rims(theirs.points, theirs.triangles, placed, opening)
