"""Fit a rig's poses and its direct map to the motion of the reference face."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from phonanim.face.model import INNER_LIP_PAIRS, FaceModel
from phonanim.rig.coordinate_descent import Problem, descend
from phonanim.rig.landmark_objective import Energy, observe_displacements, target_observations
from phonanim.rig.landmark_rig import LandmarkRig
from phonanim.rig.motion import closed_face
from phonanim.rig.rig import POSED_MODES, SIGMAS, HingeMap, Rig, pose_map
from phonanim.rig.solve import Unknowns, solve

Array = NDArray[np.float64]

ENERGY = Energy(smooth=0.0)  # the frames to fit are a sample, not a sequence
POSE_PRIOR = 20.0  # L1 per unit of control: keeps poses sparse, because an artist reads and edits them
STILLS = 0.005  # weight of each posed still, as a share of all frames
AGREEING = 1000.0  # how strongly solutions are pulled to the map's output, per round
ROUNDS = 4
KNOTS = (0.2, 1.0, 3.0, 6.0)  # mm of lip gap at which a control may change its slope
GAP_UNIT = 3.0  # mm: scales the hinges of gaps to the size of the others
RIDGE = 1e-3


def fit_rig(rig: Rig, landmark_rig: LandmarkRig, face: FaceModel, modes: Array) -> Rig:
    """Give a rig its mean, its eight poses and its direct map, from frames of the speaker's motion.

    `modes` (frames, m) are shape parameters of the training clips or a sample of them, in any order.
    """
    closed = closed_face(face, modes)
    mean, poses = fit_poses(rig, landmark_rig, face, modes, closed)
    direct = fit_direct(rig, landmark_rig, face, modes, closed)
    return replace(rig, mean=mean, poses=poses, direct=direct, face=face.id)


def fit_poses(
    rig: Rig, landmark_rig: LandmarkRig, face: FaceModel, modes: Array, closed: Array
) -> tuple[Array, Array]:
    """Controls r_0 at the mean and R at the eight poses, (controls,) and (8, controls).

    Bounded least squares of the motion that equations 2 and 3 of Taylor 2017 compute from them, over frames
    of speech and the posed stills. r_0 and R are linear in it, so it is one problem.
    """
    unknowns = Unknowns.of(landmark_rig, rig)
    frames = np.concatenate([modes, pose_modes(face)])
    counts = np.concatenate([np.ones(len(modes)), np.full(1 + 2 * POSED_MODES, STILLS * len(modes))])
    mixing = pose_weights(frames, face, rig)
    weighted = mixing * counts[:, None] / counts.sum()
    seen = observe_displacements(unknowns.shapes(landmark_rig), face, ENERGY)
    wanted = target_observations(face.instance(frames), closed, face, landmark_rig, ENERGY)
    share = weighted.T @ mixing
    problem = Problem(
        gram=np.kron(share, seen @ seen.T),
        pull=(weighted.T @ wanted @ seen.T).reshape(1, -1),
        minimum=np.tile(unknowns.minimum, len(share)),
        maximum=np.tile(unknowns.maximum, len(share)),
        sparse=np.repeat(POSE_PRIOR * np.diag(share), len(seen)),
        smooth=0.0,
        ends=np.array([1]),
    )
    solved = descend(problem, np.zeros_like(problem.pull), sweeps=3000).reshape(len(share), -1)
    controls = np.round(unknowns.to_controls(solved), 3)
    return controls[0], controls[1:]


def pose_modes(face: FaceModel) -> Array:
    """Modes of the mean and of the eight poses, (9, m), in the order of `Rig.poses`."""
    modes = np.zeros((1 + 2 * POSED_MODES, len(face.std)))
    for k in range(POSED_MODES):
        modes[1 + 2 * k : 3 + 2 * k, k] = np.array([-SIGMAS, SIGMAS]) * face.std[k]
    return modes


def pose_weights(modes: Array, face: FaceModel, rig: Rig) -> Array:
    """The share of r_0 and the weights w of equation 2, (frames, m) -> (frames, 9)."""
    names = pose_map(replace(rig, mean=rig.rest, poses=np.tile(rig.rest, (2 * POSED_MODES, 1))))
    weights = np.maximum(modes[:, :POSED_MODES] / face.std[:POSED_MODES] @ names.loads.T, 0.0)
    return np.column_stack([1.0 - weights.sum(axis=1), weights])


def fit_direct(rig: Rig, landmark_rig: LandmarkRig, face: FaceModel, modes: Array, closed: Array) -> HingeMap:
    """The hinge map closest to frame-by-frame solutions.

    Several combinations of controls can make the same mouth. So the frames are solved again, pulled to the
    map's output, and the map is fitted again; after a few rounds both agree.
    """
    shapes, standardized = face.instance(modes), modes / face.std
    solved = solve(shapes, face, landmark_rig, rig, closed, ENERGY)
    for _ in range(ROUNDS):
        said = fit_hinges(standardized, solved, rig, face)(standardized).astype(np.float64)
        drawn = replace(ENERGY, near=AGREEING)
        solved = solve(shapes, face, landmark_rig, rig, closed, drawn, proposal=said)
    return fit_hinges(standardized, solved, rig, face)


def fit_hinges(standardized: Array, solved: Array, rig: Rig, face: FaceModel) -> HingeMap:
    """Ridge regression of controls on hinges, (frames, modes), (frames, controls) -> map.

    Limits clip the map's output, so for a value at its limit any output beyond is right: its residual is
    zero there, and the regression is repeated.
    """
    names, loads, offsets = make_hinges(face)
    moving = np.any(solved != rig.rest, axis=0)
    wanted, low, high = solved[:, moving], rig.minimum[moving] + 1e-6, rig.maximum[moving] - 1e-6
    design = np.column_stack([np.ones(len(standardized)), np.maximum(standardized @ loads.T + offsets, 0)])
    penalty = np.diag([0.0, *np.full(len(names), RIDGE * len(design))])
    inverse = np.linalg.solve(design.T @ design + penalty, design.T)
    weights = inverse @ wanted
    for _ in range(30):
        said = design @ weights
        beyond = ((wanted <= low) & (said < wanted)) | ((wanted >= high) & (said > wanted))
        weights = inverse @ np.where(beyond, said, wanted)
    base, full = rig.rest.copy(), np.zeros((len(names), len(rig.controls)))
    base[moving], full[:, moving] = weights[0], weights[1:]
    return HingeMap(names, loads, offsets, full, base)


def make_hinges(face: FaceModel) -> tuple[tuple[str, ...], Array, Array]:
    """The hinges of a direct map: each mode's two halves, and lip gaps beyond some openings.

    Returns names, loads (hinges, modes) on modes in standard deviations, and offsets (hinges,).
    """
    halves = np.eye(len(face.std))
    names = [f"mode{k + 1}{sign}" for sign in "+-" for k in range(len(halves))]
    loads, offsets = [halves, -halves], [np.zeros(2 * len(halves))]
    for upper, lower in INNER_LIP_PAIRS[2:4]:  # at the side, and in the middle
        pair = face.rows((upper, lower))
        slope = (face.modes[:, pair[0], 1] - face.modes[:, pair[1], 1]) * face.std
        rest = face.mean[pair[0], 1] - face.mean[pair[1], 1]
        names += [f"gap{upper}>{knot:g}mm" for knot in KNOTS]
        loads.append(np.tile(slope / GAP_UNIT, (len(KNOTS), 1)))
        offsets.append((rest - np.array(KNOTS)) / GAP_UNIT)
    return tuple(names), np.concatenate(loads), np.concatenate(offsets)
