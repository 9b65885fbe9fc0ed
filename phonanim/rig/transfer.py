"""Blendshapes for a head that has none: deformation transfer (Sumner and Popović 2004).

A shape turns and stretches each triangle of the shipped head; the new head's triangles are asked to do as
the triangle does that they correspond to, and the vertices that come nearest to that are found. In the
gradient form of Botsch, Sumner, Pauly and Gross 2006 ("Deformation transfer for detail-preserving surface
editing") that is one Poisson system, the same for all shapes: factorized once. Needs scipy.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.face import INNER_LIPS
from phonanim.head import Head
from phonanim.rig.align import (
    NORMAL_REACH,
    Surface,
    align_bare,
    face_rows,
    scipy_parts,
    skin_rows,
    surface_of,
)
from phonanim.rig.landmarks import MeshLandmarks
from phonanim.rig.register import Pins, place_landmarks, sampled, warp

Array = NDArray[np.float64]

MARGIN = 0.05  # metres around the landmarks: chin, neck and temples move too
FAR = 0.008  # metres: a triangle farther than this from the warped model corresponds to none
TURNED = 0.3  # cosine: nor one that faces away from it
STILL = 5e-5  # metres: what the model moves less is held in place
HOLD, DRIFT = 1e-3, 1e-7  # how much places count against turns, where the model rests and where it moves
HARD = re.compile(r"eye(?!_?socket|_?lash|_?brow)|teeth|tooth|cornea", re.IGNORECASE)
SOFT = re.compile(r"gum|tongue", re.IGNORECASE)
JAWS = ("teeth_u", "teeth_l")  # of the model
PARTED = 8  # power of distances: gums go with one jaw but for a narrow seam
SAME = 1e-6  # of a head's size: vertices nearer than this are one, split for textures


@dataclass(frozen=True)
class Report:
    """How well two heads matched.

    `matched` is the share of the face's triangles that correspond to one of the model's, `carried` says
    what the parts inside the face follow, `flipped` counts triangles that some shape turns over although the
    model's are not.
    """

    matched: float
    carried: dict[str, str]
    flipped: int


def transfer(model: Head, spots: MeshLandmarks, target: Head) -> tuple[Head, MeshLandmarks, Report]:
    """Give a head without shapes the model's, and the landmarks that were found on it.

    The skin deforms; teeth, tongue and eyes follow the model's as rigid bodies, the rest the skin. Raises
    RigError when the heads cannot be brought together, MissingExtraError without scipy.
    """
    onto = align_bare(model, spots, target)
    theirs = replace(surface_of(target), points=onto(target.vertices))
    warped, found = match(model, spots, theirs)
    system = Deformation(model, warped, theirs)
    moved = np.array([system.shape(delta) for delta in model.deltas])
    carried = _carry_parts(model, target, theirs.points, moved)
    back = np.linalg.inv(onto(np.eye(3)) - onto(np.zeros((1, 3))))
    head = replace(target, targets=model.targets, deltas=moved @ back)
    return head, found, Report(system.matched_share, carried, system.flips(moved))


def match(model: Head, spots: MeshLandmarks, theirs: Surface) -> tuple[Surface, MeshLandmarks]:
    """The model warped onto a bare skin, and the landmarks there.

    The first warp finds where the lips are; the rims seen there pin the second one.
    """
    mine, rows = surface_of(model), face_rows(model, spots, MARGIN)
    mine, theirs = (replace(surface, opening=0 * surface.opening) for surface in (mine, theirs))
    found = place_landmarks(warp(mine, theirs, rows), spots, theirs)
    pins = Pins(spots.take(INNER_LIPS), found.take(INNER_LIPS).of(theirs.points))
    return warp(mine, theirs, rows, pins), found


class Deformation:
    """The Poisson system of a skin: from what a shape does to the model's triangles to its own vertices."""

    def __init__(self, model: Head, warped: Surface, theirs: Surface) -> None:
        """Match triangles and factorize."""
        sparse, factorized, _ = scipy_parts()
        self.model, self.theirs = model, theirs
        self.triangles = warped.triangles
        self.rest = np.linalg.inv(_frames(model.vertices, self.triangles))
        self.owner, self.matched = _correspondence(warped, theirs)
        self.welded, self.place = _weld(theirs)
        self.gradient, self.normals, areas = _gradient(theirs, self.place, len(self.welded), sparse)
        self.weighted = self.gradient.T @ sparse.diags(np.repeat(areas, 3))
        self.hold = self._holds()
        self.solve = factorized((self.weighted @ self.gradient + sparse.diags(self.hold)).tocsc())
        self.points = theirs.points[self.welded]

    @property
    def matched_share(self) -> float:
        """The share of the skin's triangles that correspond to one of the model's."""
        return float(self.matched.mean())

    def _holds(self) -> Array:
        """How much each vertex is held: where the model moves in no shape, it stays."""
        moved = np.linalg.norm(self.model.deltas, axis=2).max(axis=0)[self.triangles].max(axis=1)
        own = np.where(self.matched, moved[self.owner], 0.0)
        most = np.zeros(len(self.welded))
        np.maximum.at(most, self.place[self.theirs.triangles], own[:, None])
        return np.where(most < STILL, HOLD, DRIFT)

    def shape(self, delta: Array) -> Array:
        """One shape of the model on the skin, (model vertices, 3) -> (vertices, 3) metres."""
        turns = np.tile(np.eye(3), (len(self.matched), 1, 1))
        changed = _frames(self.model.vertices + delta, self.triangles) @ self.rest
        turns[self.matched] = changed[self.owner[self.matched]]
        tangent = np.eye(3) - np.einsum("ti,tj->tij", self.normals, self.normals)
        wanted = np.einsum("tij,tkj->tik", tangent, turns).reshape(-1, 3)
        right = self.weighted @ wanted + self.hold[:, None] * self.points
        solved = np.column_stack([self.solve(column) for column in right.T])
        moved = np.zeros_like(self.theirs.points)
        used = self.place >= 0
        moved[used] = (solved - self.points)[self.place[used]]
        return moved

    def flips(self, moved: Array) -> int:
        """Triangles that some shape turns by more than a right angle although the model's turns less."""
        count = 0
        for own, delta in zip(moved, self.model.deltas, strict=True):
            there = _turned(self.theirs.points, own, self.theirs.triangles)
            here = _turned(self.model.vertices, delta, self.triangles)[self.owner] & self.matched
            count += int((there & ~here).sum())
        return count


def _frames(points: Array, triangles: NDArray[np.int64]) -> Array:
    """Two edges and the scaled normal of each triangle as columns (Sumner 2004, equation 3), (t, 3, 3)."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.sqrt(np.linalg.norm(normal, axis=1, keepdims=True)).clip(1e-12)
    return np.stack([b - a, c - a, normal], axis=2)


def _correspondence(warped: Surface, theirs: Surface) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The nearest of the warped model's triangles for each of a skin's, and whether it is near enough."""
    _, _, tree = scipy_parts()
    normal, own = (_face_normals(surface) for surface in (warped, theirs))
    points, _, owners = sampled(warped)
    search = tree(np.column_stack([points, NORMAL_REACH * normal[owners]]))
    middles = theirs.points[theirs.triangles].mean(axis=1)
    nearest = search.query(np.column_stack([middles, NORMAL_REACH * own]))[1]
    owner = owners[nearest]
    near = np.linalg.norm(points[nearest] - middles, axis=1) < FAR
    return owner, near & ((normal[owner] * own).sum(axis=1) > TURNED)


def _turned(points: Array, delta: Array, triangles: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Triangles whose normal a shape turns by more than a right angle."""
    still, moved = (_face_normals(Surface(p, triangles, p[:, 0])) for p in (points, points + delta))
    return np.asarray((still * moved).sum(axis=1) < 0)


def _face_normals(surface: Surface) -> Array:
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True).clip(1e-12))


def _weld(surface: Surface) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of distinct vertices of the triangles, and each vertex's place among them, -1 when unused."""
    used = np.unique(surface.triangles)
    grain = SAME * float(np.ptp(surface.points, axis=0).max())
    _, first, inverse = np.unique(
        np.round(surface.points[used] / grain), axis=0, return_index=True, return_inverse=True
    )
    place = np.full(len(surface.points), -1)
    place[used] = inverse.ravel()
    return used[first], place


def _gradient(
    surface: Surface, place: NDArray[np.int64], count: int, sparse: Any
) -> tuple[Any, Array, Array]:
    """The gradient of a function of the vertices on each triangle (3t, count), normals and areas."""
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    double = np.linalg.norm(np.cross(b - a, c - a), axis=1).clip(1e-14)
    normal = _face_normals(surface)
    slopes = [np.cross(normal, edge) / double[:, None] for edge in (c - b, a - c, b - a)]
    rows = np.tile(np.arange(3 * len(double)), 3)
    columns = np.concatenate([np.repeat(place[surface.triangles[:, k]], 3) for k in range(3)])
    entries = np.concatenate([slope.ravel() for slope in slopes])
    return sparse.csr_matrix((entries, (rows, columns)), shape=(3 * len(double), count)), normal, double / 2


def _carry_parts(model: Head, target: Head, points: Array, moved: Array) -> dict[str, str]:
    """Move what lies inside the face, in place; returns what each part follows, by name.

    A hard piece (a tooth, an eye) follows the model's nearest one as a rigid body; gums and tongue lie
    between upper and lower teeth and share their motions; the rest (sockets, lashes) follows the skin.
    """
    _, _, tree = scipy_parts()
    skin = skin_rows(target)
    near_skin = tree(points[skin])
    bodies = {name: model.vertices[rows] for name, rows in model.parts.items() if HARD.search(name)}
    own = {name: [place] for name, place in bodies.items()}  # with the target's that follow them
    carried: dict[str, set[str]] = {}
    for name, rows in sorted(_pieces(target, skin), key=lambda piece: not HARD.search(piece[0])):
        if HARD.search(name) and bodies:
            nearest = min(
                bodies, key=lambda part: float(np.median(tree(bodies[part]).query(points[rows])[0]))
            )
            own[nearest].append(points[rows])
            shares = {nearest: np.ones(len(rows))}
        elif SOFT.search(name) and {*JAWS} <= {*bodies}:
            upper, lower = (np.concatenate(own[jaw][1:] or own[jaw]) for jaw in JAWS)
            shares = _shares(points[rows], upper, lower, model)
        else:
            moved[:, rows] = moved[:, skin[near_skin.query(points[rows])[1]]]
            shares = {}
        if shares:
            moved[:, rows] = _mixed(model, shares, points[rows])
        carried.setdefault(name, set()).update(shares or {"skin"})
    return {name: ", ".join(sorted(parts)) for name, parts in carried.items()}


def _mixed(model: Head, shares: dict[str, Array], points: Array) -> Array:
    """Points that take part in the motions of some of the model's parts, (shapes, n, 3)."""
    moved = np.zeros((len(model.deltas), *points.shape))
    for part, share in shares.items():
        rows = model.parts[part]
        for shape, delta in zip(moved, model.deltas, strict=True):
            shape += share[:, None] * _rigid(model.vertices[rows], delta[rows], points)
    return moved


def _shares(points: Array, upper: Array, lower: Array, model: Head) -> dict[str, Array]:
    """How much each point moves with the upper and with the lower teeth; the tongue goes with these."""
    _, _, tree = scipy_parts()
    rise, fall = (tree(teeth).query(points)[0] for teeth in (upper, lower))
    if "tongue" in model.parts:
        fall = np.minimum(fall, tree(model.vertices[model.parts["tongue"]]).query(points)[0])
    share = 1 / (1 + (fall / rise.clip(1e-6)) ** PARTED)
    return {JAWS[0]: 1 - share, JAWS[1]: share}


def _pieces(head: Head, skin: NDArray[np.int64]) -> list[tuple[str, NDArray[np.int64]]]:
    """The connected pieces that are not skin, with the names of their parts."""
    sparse, _, _ = scipy_parts()
    from scipy.sparse.csgraph import connected_components

    edges = head.triangles[:, [0, 1, 1, 2]].reshape(-1, 2)
    count = len(head.vertices)
    graph = sparse.coo_matrix((np.ones(len(edges)), edges.T), shape=(count, count))
    labels = connected_components(graph, directed=False)[1]
    inner = np.setdiff1d(np.arange(count), skin)
    pieces = []
    for name, part in head.parts.items():
        rows = inner[(inner >= part.start) & (inner < part.stop)]
        pieces += [(name, rows[labels[rows] == label]) for label in np.unique(labels[rows])]
    return pieces


def _rigid(points: Array, delta: Array, others: Array) -> Array:
    """How other points move with the rigid body that moves points by delta, at best (Kabsch 1976)."""
    if np.abs(delta).max() < STILL:
        return np.zeros_like(others)
    centre, middle = points.mean(axis=0), (points + delta).mean(axis=0)
    left, _, right = np.linalg.svd((points - centre).T @ (points + delta - middle))
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    return np.asarray((others - centre) @ (left @ right) + middle - others)
