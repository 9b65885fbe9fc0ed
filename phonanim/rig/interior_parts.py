"""Transfer the parts inside the face: teeth and eyes as rigid bodies, gums between them.

Needs scipy.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from phonanim.rig.align import scipy_parts, skin_rows
from phonanim.rig.deform import STILL
from phonanim.rig.geometry import connected_labels, weld
from phonanim.rig.head import Head

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

HARD = re.compile(r"eye(?!_?socket|_?lash|_?brow)|teeth|tooth|cornea", re.IGNORECASE)
SOFT = re.compile(r"gum|tongue", re.IGNORECASE)
JAWS = ("teeth_u", "teeth_l")  # of the model
PARTED = 8  # power of distances: gums follow one jaw except in a narrow seam


def outer_rows(head: Head) -> Rows:
    """The skin with the sockets and linings connected to it, which deform as one surface."""
    skin = skin_rows(head)
    labels = _joined(head)
    with_it = np.isin(labels, labels[skin])
    for name, part in head.parts.items():
        if HARD.search(name) or SOFT.search(name):
            with_it[part] = False
    with_it[skin] = True
    return np.flatnonzero(with_it)


def carry_parts(model: Head, target: Head, points: Array, moved: Array) -> dict[str, str]:
    """Move the parts inside the face, in place; returns what each part follows, by name.

    A hard piece (a tooth, an eye) follows the model's nearest one as a rigid body. Gums and tongue are
    between upper and lower teeth and blend their motions. The rest (lashes) follows the skin.
    """
    _, _, tree = scipy_parts()
    outer = outer_rows(target)
    near_skin = tree(points[outer])
    bodies = {name: model.vertices[rows] for name, rows in model.parts.items() if HARD.search(name)}
    own = {name: [place] for name, place in bodies.items()}  # with the target's that follow them
    carried: dict[str, set[str]] = {}
    for name, rows in sorted(_pieces(target, outer), key=lambda piece: not HARD.search(piece[0])):
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
            moved[:, rows] = moved[:, outer[near_skin.query(points[rows])[1]]]
            shares = {}
        if shares:
            moved[:, rows] = _mixed(model, shares, points[rows])
        carried.setdefault(name, set()).update(shares or {"skin"})
    return {name: ", ".join(sorted(parts)) for name, parts in carried.items()}


def _mixed(model: Head, shares: dict[str, Array], points: Array) -> Array:
    """Motion of points that follow some of the model's parts, (shapes, n, 3)."""
    moved = np.zeros((len(model.deltas), *points.shape))
    for part, share in shares.items():
        rows = model.parts[part]
        for shape, delta in zip(moved, model.deltas, strict=True):
            shape += share[:, None] * _rigid(model.vertices[rows], delta[rows], points)
    return moved


def _shares(points: Array, upper: Array, lower: Array, model: Head) -> dict[str, Array]:
    """How much each point moves with the upper and the lower teeth; the tongue follows the lower."""
    _, _, tree = scipy_parts()
    rise, fall = (tree(teeth).query(points)[0] for teeth in (upper, lower))
    if "tongue" in model.parts:
        fall = np.minimum(fall, tree(model.vertices[model.parts["tongue"]]).query(points)[0])
    share = 1 / (1 + (fall / rise.clip(1e-6)) ** PARTED)
    return {JAWS[0]: 1 - share, JAWS[1]: share}


def _pieces(head: Head, outer: Rows) -> list[tuple[str, Rows]]:
    """The connected pieces outside the outer surface, with the names of their parts."""
    labels = _joined(head)
    inner = np.setdiff1d(np.arange(len(head.vertices)), outer)
    pieces = []
    for name, part in head.parts.items():
        rows = inner[(inner >= part.start) & (inner < part.stop)]
        pieces += [(name, rows[labels[rows] == label]) for label in np.unique(labels[rows])]
    return pieces


def _joined(head: Head) -> Rows:
    """A component number for each vertex, the same for vertices that triangles connect, (vertices,)."""
    rows, place = weld(head.vertices, head.triangles)
    labels = connected_labels(place[head.triangles], len(rows))
    return np.where(place >= 0, labels[place], -1)


def _rigid(points: Array, delta: Array, others: Array) -> Array:
    """Motion of other points with the rigid body that best fits points moved by delta (Kabsch 1976)."""
    if np.abs(delta).max() < STILL:
        return np.zeros_like(others)
    centre, middle = points.mean(axis=0), (points + delta).mean(axis=0)
    left, _, right = np.linalg.svd((points - centre).T @ (points + delta - middle))
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    return np.asarray((others - centre) @ (left @ right) + middle - others)
