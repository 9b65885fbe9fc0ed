"""Where the shipped head's points lie on another head: alignment, then a smooth warp onto its surface.

The warp is that of Amberg, Romdhani and Vetter 2007 ("Optimal step nonrigid ICP algorithms for surface
registration"), with a displacement per vertex held smooth by the graph Laplacian, and its stiffness
lowered step by step. Needs scipy.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError, RigError
from phonanim.head import Head
from phonanim.morphs import plain
from phonanim.rig.landmarks import MeshLandmarks
from phonanim.rig.rims import put_on_rims
from phonanim.rig.tables import VRM, read_viseme_shapes

Array = NDArray[np.float64]

INNER_PARTS = re.compile(r"eye|teeth|tooth|gum|tongue|socket|lash|hair|brow|tear|cornea", re.IGNORECASE)
OPENINGS = ("jawopen", "aa", "visemeaa", "a", "mouthopen")  # what tells the lower lip from the upper
FEWEST_NAMES = 4
NORMAL_REACH = 0.010  # metres: a surface that faces the other way counts as this far
OPENING_REACH = 0.020  # metres: as far counts a point of the other lip
STIFFNESS = (50.0, 20.0, 8.0, 3.0, 1.0, 0.4)
STEPS = 4  # per stiffness
FACE_MARGIN = 0.03  # metres around the landmarks that the warp carries along
SAMPLES = np.array(
    [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
        [2, 2, 2],
        [1, 1, 0],
        [0, 1, 1],
        [1, 0, 1],
        [4, 1, 1],
        [1, 4, 1],
        [1, 1, 4],
    ]
)


@dataclass(frozen=True)
class Surface:
    """A skin to match: points, triangles, and features whose nearness tells what corresponds."""

    points: Array
    triangles: NDArray[np.int64]
    opening: Array

    def features(self) -> Array:
        """(points, 7): place, direction and how the point moves as the mouth opens, all in metres."""
        return np.column_stack(
            [self.points, NORMAL_REACH * normals(self.points, self.triangles), OPENING_REACH * self.opening]
        )


def suggest_landmarks(model: Head, spots: MeshLandmarks, target: Head) -> MeshLandmarks:
    """The model's landmarks on another head with blendshapes, in any units and axes.

    Raises RigError when the heads cannot be brought together, MissingExtraError without scipy.
    """
    onto = align(model, target)
    mine, theirs = _surface(model), _surface(target)
    if not theirs.opening.any():
        mine = replace(mine, opening=theirs.opening[:1].repeat(len(mine.opening)))
    theirs = replace(theirs, points=onto(target.vertices))
    warped = model.vertices.copy()
    rows = _face_rows(model, spots)
    warped[rows] = warp(mine, theirs, rows)
    found = _on_surface(replace(mine, points=warped), spots, theirs)
    return put_on_rims(theirs.points, theirs.triangles, found)


def align(model: Head, target: Head) -> Callable[[Array], Array]:
    """A similarity that brings the target onto the model: a function of points, (n, 3) -> (n, 3) metres.

    Shapes of the same name move the same part of the face, so the places that they move are matched
    (Umeyama 1991). Raises RigError when too few names are known.
    """
    ours, theirs = _anchors(with_visemes(model)), _anchors(target)
    names = sorted(set(ours) & set(theirs))
    if len(names) < FEWEST_NAMES:
        raise RigError(
            f"the head has {len(names)} shapes whose names are known, too few to find its face by; name some "
            "as ARKit or VRM does (eyeBlinkLeft, eyeBlinkRight, jawOpen, mouthPucker), or give --landmarks"
        )
    goal, points = np.array([ours[n] for n in names]), np.array([theirs[n] for n in names])
    centre, middle = points.mean(axis=0), goal.mean(axis=0)
    left, stretch, right = np.linalg.svd((points - centre).T @ (goal - middle))
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = (left * sign) @ right
    scale = float((stretch * sign).sum() / ((points - centre) ** 2).sum())
    return lambda moved: np.asarray((moved - centre) @ turn * scale + middle)


def with_visemes(model: Head) -> Head:
    """The shipped head with visemes and VRM's expressions for shapes as well."""
    names, mixtures = read_viseme_shapes(model.targets)
    blinks = np.array([[t == f"eyeBlink{side}" for t in model.targets] for side in ("Left", "Right")], float)
    known = {
        **{f"viseme_{name}": mixture for name, mixture in zip(names, mixtures, strict=True)},
        **{vrm: mixtures[names.index(viseme)] for vrm, viseme in VRM.items()},
        **{"blinkLeft": blinks[0], "blinkRight": blinks[1], "blink": blinks.sum(axis=0)},
    }
    added = np.tensordot(np.array(list(known.values())), model.deltas, axes=1)
    return replace(model, targets=(*model.targets, *known), deltas=np.concatenate([model.deltas, added]))


def _anchors(head: Head) -> dict[str, Array]:
    """Where each shape moves the skin, on average, by its plain name."""
    skin = _skin_rows(head)
    found = {}
    for name, delta in zip(head.targets, head.deltas, strict=True):
        weight = (delta[skin] ** 2).sum(axis=1)
        if weight.sum() > 0:
            found[plain(name)] = np.asarray(weight @ head.vertices[skin] / weight.sum())
    return found


def _skin_rows(head: Head) -> NDArray[np.int64]:
    """Rows of the parts that are not inside the face."""
    outer = [part for name, part in head.parts.items() if not INNER_PARTS.search(name)]
    parts = outer or list(head.parts.values())
    return np.concatenate([np.arange(part.start, part.stop) for part in parts])


def _surface(head: Head) -> Surface:
    skin = np.isin(head.triangles, _skin_rows(head)).all(axis=1)
    known = [i for i, name in enumerate(head.targets) if plain(name) in OPENINGS]
    opening = np.zeros(len(head.vertices))
    if known:
        moved = np.linalg.norm(head.deltas[known[0]], axis=1)
        opening = moved / max(moved.max(), 1e-9)
    return Surface(head.vertices, head.triangles[skin], opening)


def _face_rows(head: Head, spots: MeshLandmarks) -> NDArray[np.int64]:
    """The skin around the landmarks."""
    places = spots.of(head.vertices)
    low, high = places.min(axis=0) - FACE_MARGIN, places.max(axis=0) + FACE_MARGIN
    skin = _skin_rows(head)
    inside = ((head.vertices[skin] > low) & (head.vertices[skin] < high)).all(axis=1)
    return skin[inside]


def warp(mine: Surface, theirs: Surface, rows: NDArray[np.int64]) -> Array:
    """Some points of one surface moved onto another, smoothly, (rows, 3) metres."""
    sparse, factorized, tree = _scipy()
    goal_points, goal_features, _ = _sampled(theirs)
    search = tree(goal_features)
    laplacian = _laplacian(mine.triangles, rows, sparse)
    smooth = laplacian.T @ laplacian
    points = mine.points.copy()
    start = mine.points[rows]
    for stiffness in STIFFNESS:
        solve = factorized((sparse.identity(len(rows)) + stiffness * smooth).tocsc())
        for _ in range(STEPS):
            features = replace(mine, points=points).features()[rows]
            goals = goal_points[search.query(features)[1]]
            points[rows] = start + solve(goals - start)
    return np.asarray(points[rows])


def _laplacian(triangles: NDArray[np.int64], rows: NDArray[np.int64], sparse: Any) -> Any:
    """How far each point's value lies from the mean of its neighbours', (rows, rows)."""
    place = np.full(int(triangles.max()) + 1, -1)
    place[rows] = np.arange(len(rows))
    edges = place[np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])]
    edges = edges[(edges >= 0).all(axis=1)]
    both = np.unique(np.concatenate([edges, edges[:, ::-1]]), axis=0)
    near = sparse.csr_matrix((np.ones(len(both)), both.T), shape=(len(rows), len(rows)))
    degree = np.maximum(np.asarray(near.sum(axis=1)).ravel(), 1)
    return sparse.identity(len(rows)) - sparse.diags(1 / degree) @ near


def _sampled(surface: Surface) -> tuple[Array, Array, NDArray[np.int64]]:
    """Points spread over the triangles with their features, (samples, 3), (samples, 7), and triangles."""
    weights = SAMPLES / SAMPLES.sum(axis=1, keepdims=True)
    features = np.einsum("sk,tkf->tsf", weights, surface.features()[surface.triangles])
    points = np.einsum("sk,tkf->tsf", weights, surface.points[surface.triangles])
    owners = np.repeat(np.arange(len(surface.triangles)), len(weights))
    return points.reshape(-1, 3), features.reshape(-1, features.shape[2]), owners


def _on_surface(warped: Surface, spots: MeshLandmarks, theirs: Surface) -> MeshLandmarks:
    """Landmarks of the warped model, put on the nearest samples of the other surface."""
    _, _, tree = _scipy()
    _, features, owners = _sampled(theirs)
    found = tree(features).query(spots.of(warped.features()))[1]
    weights = SAMPLES / SAMPLES.sum(axis=1, keepdims=True)
    return MeshLandmarks(spots.numbers, theirs.triangles[owners[found]], weights[found % len(weights)])


def normals(points: Array, triangles: NDArray[np.int64]) -> Array:
    """Outward directions of length one at the vertices, (n, 3)."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    summed = np.zeros_like(points)
    for corner in range(3):
        np.add.at(summed, triangles[:, corner], np.cross(b - a, c - a))
    return np.asarray(summed / np.linalg.norm(summed, axis=1, keepdims=True).clip(1e-12))


def _scipy() -> tuple[Any, Any, Any]:
    try:
        from scipy import sparse
        from scipy.sparse.linalg import factorized
        from scipy.spatial import cKDTree
    except ImportError as error:
        raise MissingExtraError("fitting a rig needs scipy: pip install 'phonanim[train]'") from error
    return sparse, factorized, cKDTree
