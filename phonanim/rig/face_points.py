"""A face from a few points: those that a person marks on a character, and all others found from them."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim.core.lexicon import LEXICON
from phonanim.errors import RigError
from phonanim.rig.align import Surface, face_rows, surface_of
from phonanim.rig.head import Head
from phonanim.rig.landmarks import MeshLandmarks
from phonanim.rig.register import Pins, bent_points, opening_near, place_landmarks, warp_surface
from phonanim.rig.rims import OPENED

Array = NDArray[np.float64]

TABLE = LEXICON / "rigs" / "face_points.csv"
LIPS = (13, 14)  # landmarks of the inner lips
APART = 0.001  # metres between lips that are not marked as one
FARTHEST = 0.03  # metres from where a marked point is expected, on a face of the shipped head's size


@dataclass(frozen=True)
class FacePoint:
    """A point that a person can mark: its landmark and its name.

    A face does not go without one that is `needed`; one that is `opened` is seen when the mouth is open.
    """

    landmark: int
    name: str
    needed: bool
    opened: bool


def face_points() -> tuple[FacePoint, ...]:
    """The points to mark, in order."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return tuple(
        FacePoint(int(row["landmark"]), row["name"], row["needed"] == "yes", row["opened"] == "yes")
        for row in rows
    )


def complete_landmarks(
    model: Head, spots: MeshLandmarks, target: Head, given: MeshLandmarks
) -> MeshLandmarks:
    """All landmarks of a model on another head, from those that are given on it.

    The heads are aligned by the given points, the model is bent until they meet, and warped onto the head
    with the points held. Names of shapes are not needed. Raises RigError when a point is missing that a face
    needs, or one is far from where the others say.
    """
    _check(given, target)
    known = given.take([int(number) for number in given.numbers if number in spots.numbers])
    numbers = known.numbers.tolist()
    goal, points = spots.take(numbers).of(model.vertices), known.of(target.vertices)
    aligned = _similarity(points, goal)
    _check_places(numbers, aligned(points), goal)
    mine, theirs = surface_of(model), surface_of(target)
    if not theirs.opening.any():
        mine = replace(mine, opening=np.zeros_like(mine.opening))
    theirs = replace(theirs, points=aligned(target.vertices))
    mine = replace(mine, points=bent_points(mine.points, goal, points, aligned))
    mouth = aligned(known.take((61, 291)).of(target.vertices)).mean(axis=0)
    mine, theirs = (opening_near(surface, mouth) for surface in (mine, theirs))
    pins = Pins(spots.take(numbers), aligned(points))
    warped = warp_surface(mine, theirs, face_rows(model, spots), pins)
    found = place_landmarks(warped, spots, theirs)
    if not _on_two_lips(known, theirs):
        known = known.take([number for number in numbers if number not in LIPS])
        numbers = known.numbers.tolist()
    corners, weights = found.corners.copy(), found.weights.copy()
    rows = [int(np.flatnonzero(found.numbers == number)[0]) for number in numbers]
    corners[rows], weights[rows] = known.corners, known.weights
    return MeshLandmarks(found.numbers, corners, weights)


def _on_two_lips(known: MeshLandmarks, surface: Surface) -> bool:
    """Whether the inner lips are marked on two lips: a click for one may meet the other in a closed mouth."""
    upper, lower = known.take(LIPS).of(np.column_stack([surface.points, surface.opening]))
    if surface.opening.any():
        return bool(lower[3] - upper[3] > OPENED)
    return bool(np.linalg.norm(lower - upper) > APART)


def _check(given: MeshLandmarks, target: Head) -> None:
    lacking = [point for point in face_points() if point.needed and point.landmark not in given.numbers]
    if lacking:
        raise RigError(
            f"the landmark table lacks {lacking[0].landmark} ({lacking[0].name}); "
            "mark it: phonanim rig landmarks"
        )
    last = int(given.corners.max(initial=0))
    if last >= len(target.vertices) or int(given.corners.min(initial=0)) < 0:
        raise RigError(
            f"the landmark table names vertex {last}, and the head has {len(target.vertices)}; mark the "
            "points on this file: phonanim rig landmarks"
        )


def _similarity(points: Array, goal: Array) -> Callable[[Array], Array]:
    """The similarity that brings points to a goal (Umeyama 1991), as a function of points."""
    centre, middle = points.mean(axis=0), goal.mean(axis=0)
    left, stretch, right = np.linalg.svd((points - centre).T @ (goal - middle))
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = (left * sign) @ right
    size = float(((points - centre) ** 2).sum())
    if size == 0:
        raise RigError("the marked points coincide; mark them anew: phonanim rig landmarks")
    scale = float((stretch * sign).sum() / size)
    return lambda moved: np.asarray((moved - centre) @ turn * scale + middle)


def _check_places(numbers: list[int], placed: Array, goal: Array) -> None:
    """Raise RigError for the marked point that is farthest from its place, where that is too far."""
    apart = np.linalg.norm(placed - goal, axis=1)
    worst = int(apart.argmax())
    if apart[worst] > FARTHEST:
        names = {point.landmark: point.name for point in face_points()}
        raise RigError(
            f"the landmark {numbers[worst]} ({names.get(numbers[worst], 'of the table')}) lies "
            f"{apart[worst] * 1000:.0f} mm from its place by the other points; are left and right, the "
            "character's own, in their places? mark it anew: phonanim rig landmarks"
        )
