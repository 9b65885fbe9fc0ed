"""Align two heads: by what their shapes move, or by their faces alone.

Needs trimesh and scipy.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError, RigError
from phonanim.rig.geometry import vertex_normals
from phonanim.rig.head import Head
from phonanim.rig.landmarks import MARK, MeshLandmarks
from phonanim.rig.names import known_controls
from phonanim.rig.tables import VRM, read_viseme_shapes

Array = NDArray[np.float64]

INNER_PARTS = re.compile(
    r"eye|teeth|tooth|gum|tongue|socket|lash|hair|brow|tear|cornea|facemouth|mouth_?(in|cav|bag)|glasses",
    re.IGNORECASE,
)
OPENINGS = ("jawopen", "aa", "visemeaa", "a", "mouthopen")  # these separate the lower lip from the upper
FEWEST_NAMES = 4
NORMAL_REACH = 0.010  # metres: distance added for a surface that faces the other way
OPENING_REACH = 0.020  # metres: distance added for a point of the other lip
ICP_STEPS = 60
UNSURE = 0.02  # metres between places of the same names above which the face is not found
LEVEL, HEAD, SKULL = 0.03, 0.25, 0.12  # metres: above and below the face, around it, depth of a whole head
LOST = 0.015  # metres between faces above which alignment has failed
FACE_MARGIN = 0.03  # metres around the landmarks that count as face


@dataclass(frozen=True)
class Surface:
    """A skin to match: points, triangles, and features whose distances define correspondence."""

    points: Array
    triangles: NDArray[np.int64]
    opening: Array

    def features(self) -> Array:
        """(points, 7): position, direction and motion as the mouth opens, all in metres."""
        return np.column_stack(
            [
                self.points,
                NORMAL_REACH * vertex_normals(self.points, self.triangles),
                OPENING_REACH * self.opening,
            ]
        )


def align_heads(model: Head, target: Head) -> Callable[[Array], Array]:
    """A similarity from the target to the model, as a function of points, (n, 3) -> (n, 3) metres.

    Shapes with the same name move the same part of the face, so the centres of their motion are matched
    (Umeyama 1991). Raises RigError when too few names are known.
    """
    goal, points = known_places(model, target)
    centre, middle = points.mean(axis=0), goal.mean(axis=0)
    left, stretch, right = np.linalg.svd((points - centre).T @ (goal - middle))
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = (left * sign) @ right
    scale = float((stretch * sign).sum() / ((points - centre) ** 2).sum())
    aligned = (points - centre) @ turn * scale + middle
    check_alignment(goal, aligned, (target.vertices - centre) @ turn * scale + middle)
    return lambda moved: np.asarray((moved - centre) @ turn * scale + middle)


def check_alignment(goal: Array, aligned: Array, vertices: Array) -> None:
    """Check that places of an aligned head are where the model's are, and that its face looks forward.

    Raises RigError, which asks for landmarks, where they are not.
    """
    apart = float(np.sqrt(((aligned - goal) ** 2).sum(axis=1).mean()))
    if not apart < UNSURE:
        raise RigError(
            f"is not sure where the face is: its shapes lie {apart * 1000:.0f} mm from where their names "
            f"say, on average; mark it: {MARK}"
        )
    face = aligned.mean(axis=0)
    level = vertices[
        (np.abs(vertices[:, 1] - face[1]) < LEVEL) & (np.linalg.norm(vertices - face, axis=1) < HEAD)
    ]
    low, high = np.percentile(level[:, 2], (1, 99)) if len(level) else (0.0, 0.0)
    if high - low > SKULL and face[2] < (low + high) / 2:
        raise RigError(
            "is not sure where the face is: most of the head is in front of the parts that its shapes move; "
            f"mark it: {MARK}"
        )


def known_places(model: Head, target: Head) -> tuple[Array, Array]:
    """The centres of what shapes of the same names move, (names, 3), on the model and on the target.

    Raises RigError when too few names are known.
    """
    ours, theirs = _anchors(add_viseme_shapes(model)), _anchors(target)
    names = sorted(set(ours) & set(theirs))
    if len(names) < FEWEST_NAMES:
        raise RigError(
            f"the head has {len(names)} shapes whose names are known, too few to find its face by; name some "
            f"as ARKit or VRM does (eyeBlinkLeft, eyeBlinkRight, jawOpen, mouthPucker), or mark it: {MARK}"
        )
    return np.array([ours[n] for n in names]), np.array([theirs[n] for n in names])


def add_viseme_shapes(model: Head) -> Head:
    """The shipped head with visemes and VRM's expressions as additional shapes."""
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
    """The centre of each shape's motion on the skin, by plain name."""
    skin = skin_rows(head)
    found: dict[str, Array] = {}
    for name, delta in zip(head.targets, head.deltas, strict=True):
        weight = (delta[skin] ** 2).sum(axis=1)
        if weight.sum() > 0:
            centre = np.asarray(weight @ head.vertices[skin] / weight.sum())
            found |= {known: centre for known in known_controls(name) if known not in found}
    return found


def align_bare_head(model: Head, spots: MeshLandmarks, target: Head) -> Callable[[Array], Array]:
    """As `align`, for a head without shapes that looks along z with y up.

    Noses and skulls are aligned first, then the faces (iterative closest points without the worst fifth).
    Raises RigError when the alignment fails.
    """
    _, _, tree = scipy_parts()
    mine, theirs, rows = surface_of(model), surface_of(target), face_rows(model, spots)
    (breadth, nose), (other, tip) = _skull(model), _skull(target)
    scale, turn, shift = breadth / other, np.eye(3), nose - tip * breadth / other
    skin = skin_rows(target)
    goal = replace(mine, opening=0 * mine.opening).features()[rows]
    for _ in range(ICP_STEPS):
        moved = replace(theirs, points=theirs.points @ turn * scale + shift, opening=0 * theirs.opening)
        apart, nearest = tree(moved.features()[skin]).query(goal)
        close = apart <= np.percentile(apart, 80)
        scale, turn, shift = _similarity(target.vertices[skin][nearest[close]], model.vertices[rows][close])
    if np.median(apart) > LOST:
        raise RigError(
            "the mesh does not look like a head that faces forward, y up; turn it, or cut off the rest"
        )
    return lambda points: np.asarray(points @ turn * scale + shift)


def _skull(head: Head) -> tuple[float, Array]:
    """The width of the skull above the ears, and the tip of the nose."""
    points = head.vertices[skin_rows(head)]
    top, breadth = points[:, 1].max(), float(np.ptp(points[:, 0]))
    for _ in range(50):  # the widest part is half a width below the crown
        band = points[np.abs(top - points[:, 1] - 0.5 * breadth) < 0.15 * breadth]
        if len(band) == 0:
            break
        breadth = 2 * float(np.percentile(np.abs(band[:, 0] - np.median(band[:, 0])), 90))
    face = points[points[:, 1] > top - 1.35 * breadth]
    return max(breadth, 1e-9), np.asarray(face[face[:, 2].argmax()])


def _similarity(points: Array, goal: Array) -> tuple[float, Array, Array]:
    """Scale, rotation and translation of points onto a goal; the scale is the ratio of their sizes.

    The least-squares scale shrinks with every wrong neighbour, so iterative closest points would collapse.
    """
    centre, middle = points.mean(axis=0), goal.mean(axis=0)
    left, _, right = np.linalg.svd((points - centre).T @ (goal - middle))
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    scale = float(np.sqrt(((goal - middle) ** 2).sum() / ((points - centre) ** 2).sum()))
    return scale, left @ right, middle - centre @ (left @ right) * scale


def face_rows(head: Head, spots: MeshLandmarks, margin: float = FACE_MARGIN) -> NDArray[np.int64]:
    """The skin within a margin, in metres, of the box of the landmarks."""
    places = spots.of(head.vertices)
    low, high = places.min(axis=0) - margin, places.max(axis=0) + margin
    skin = skin_rows(head)
    inside = ((head.vertices[skin] > low) & (head.vertices[skin] < high)).all(axis=1)
    return skin[inside]


def skin_rows(head: Head) -> NDArray[np.int64]:
    """Rows of the parts that are not inside the face."""
    outer = [part for name, part in head.parts.items() if not INNER_PARTS.search(name)]
    parts = outer or list(head.parts.values())
    return np.concatenate([np.arange(part.start, part.stop) for part in parts])


def surface_of(head: Head) -> Surface:
    """The skin of a head, with its motion as the mouth opens."""
    skin = np.isin(head.triangles, skin_rows(head)).all(axis=1)
    known = [i for i, name in enumerate(head.targets) if set(known_controls(name)) & set(OPENINGS)]
    opening = np.zeros(len(head.vertices))
    if known:
        moved = np.linalg.norm(head.deltas[known[0]], axis=1)
        opening = moved / max(moved.max(), 1e-9)
    return Surface(head.vertices, head.triangles[skin], opening)


def scipy_parts() -> tuple[Any, Any, Any]:
    """Import from scipy: sparse matrices, their factorization, nearest neighbours."""
    try:
        from scipy import sparse
        from scipy.sparse.linalg import factorized
        from scipy.spatial import cKDTree
    except ImportError as error:
        raise MissingExtraError("fitting a rig needs scipy: pip install 'phonanim[rig]'") from error
    return sparse, factorized, cKDTree
