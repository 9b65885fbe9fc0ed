"""Landmarks to controls: what was posed is found again, sides agree, bounds hold."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from faces import blank_rig, head_face, head_landmark_rig

from phonanim.errors import RigError
from phonanim.face.model import lip_aperture, lip_width
from phonanim.pipeline import load_model
from phonanim.rig import load_rig
from phonanim.rig.coordinate_descent import Problem, descend
from phonanim.rig.fit import fit_rig, make_hinges
from phonanim.rig.head import load_head
from phonanim.rig.landmark_objective import CLOSED_GAP, Energy
from phonanim.rig.landmark_rig import control_partners, landmark_partners, make_landmark_rig, mirror_faces
from phonanim.rig.landmarks import read_landmarks, shipped_landmarks
from phonanim.rig.motion import closed_face, read_motion
from phonanim.rig.retarget import retarget
from phonanim.rig.solve import solve

EXACT = Energy(gap=0.0, sparse=0.01, smooth=0.0)  # gaps count from where lips touch, not from rest


def posed(**controls: float) -> np.ndarray:
    landmark_rig = head_landmark_rig()
    values = np.zeros((1, len(landmark_rig.controls)))
    for name, value in controls.items():
        for full in (name, f"{name}Left", f"{name}Right"):
            if full in landmark_rig.controls:
                values[0, landmark_rig.controls.index(full)] = value
    return values


@pytest.mark.parametrize(
    "controls",
    [{"jawOpen": 0.4}, {"jawOpen": 0.3, "mouthPucker": 0.5}, {"jawOpen": 0.3, "mouthLowerDown": 0.4}],
)
def test_posed_controls_are_found_again(controls: dict[str, float]) -> None:
    landmark_rig, face = head_landmark_rig(), head_face()
    wanted = posed(**controls)
    solved = solve(
        landmark_rig.pose(wanted), face, landmark_rig, blank_rig(landmark_rig), landmark_rig.rest, EXACT
    )
    np.testing.assert_allclose(solved, wanted, atol=0.05)


def test_lips_open_and_widen_as_the_face_does() -> None:
    landmark_rig, face = head_landmark_rig(), head_face()
    shapes = landmark_rig.pose(
        np.concatenate([posed(jawOpen=jaw, mouthStretch=0.5 - jaw) for jaw in (0.1, 0.3, 0.5)])
    )
    again = landmark_rig.pose(solve(shapes, face, landmark_rig, blank_rig(landmark_rig), landmark_rig.rest))
    opened = lip_aperture(shapes, face) - lip_aperture(landmark_rig.rest[None], face) - CLOSED_GAP
    np.testing.assert_allclose(lip_aperture(again, face), opened, atol=0.3)
    np.testing.assert_allclose(lip_width(again, face), lip_width(shapes, face), atol=0.4)


def test_the_closed_face_closes_the_head() -> None:
    landmark_rig, face = head_landmark_rig(), head_face()
    solved = solve(landmark_rig.rest[None], face, landmark_rig, blank_rig(landmark_rig), landmark_rig.rest)
    assert solved.max() < 0.2
    assert abs(lip_aperture(landmark_rig.pose(solved), face)[0]) < 0.3


def test_mirrored_faces_give_mirrored_controls() -> None:
    landmark_rig, face = head_landmark_rig(), head_face()
    rig, partner = blank_rig(landmark_rig), landmark_partners(landmark_rig.rest)
    shape = landmark_rig.pose(posed(jawOpen=0.3)) + np.random.default_rng(1).normal(
        0, 0.5, landmark_rig.rest.shape
    )
    flipped = landmark_rig.rest + mirror_faces(shape - landmark_rig.rest, partner)
    one, other = (solve(s, face, landmark_rig, rig, landmark_rig.rest, EXACT) for s in (shape, flipped))
    swap = control_partners(landmark_rig)
    np.testing.assert_allclose(other, one[:, swap], atol=1e-9)


def test_limits_hold_and_mouth_close_stays_below_jaw_open() -> None:
    landmark_rig, face = head_landmark_rig(), head_face()
    rig = blank_rig(landmark_rig)
    modes = np.random.default_rng(2).normal(size=(300, 5)) * face.std * 2
    solved = solve(face.instance(modes), face, landmark_rig, rig, landmark_rig.rest)
    assert solved.min() >= 0
    assert solved.max() <= 1
    ((close, jaw),) = rig.at_most
    assert (solved[:, close] <= solved[:, jaw] + 1e-12).all()


def test_ties_make_curves_smoother_but_not_across_clips() -> None:
    landmark_rig, face = head_landmark_rig(), head_face()
    rig = blank_rig(landmark_rig)
    modes = np.random.default_rng(3).normal(size=(40, 5)) * face.std
    shapes = face.instance(modes)
    loose, tied = (
        solve(shapes, face, landmark_rig, rig, landmark_rig.rest, Energy(smooth=smooth))
        for smooth in (0.0, 3000.0)
    )
    assert np.abs(np.diff(tied, axis=0)).sum() < 0.8 * np.abs(np.diff(loose, axis=0)).sum()
    halves = [solve(part, face, landmark_rig, rig, landmark_rig.rest) for part in (shapes[:20], shapes[20:])]
    both = solve(shapes, face, landmark_rig, rig, landmark_rig.rest, lengths=np.array([20, 20]))
    np.testing.assert_allclose(both, np.concatenate(halves), atol=1e-3)


def test_a_proposal_draws() -> None:
    landmark_rig, face = head_landmark_rig(), head_face()
    wanted = posed(jawOpen=0.5)
    near = solve(
        landmark_rig.rest[None],
        face,
        landmark_rig,
        blank_rig(landmark_rig),
        landmark_rig.rest,
        Energy(near=1e7),
        proposal=wanted,
    )
    np.testing.assert_allclose(near, wanted, atol=0.01)


def test_a_head_without_the_controls_is_said() -> None:
    landmark_rig = head_landmark_rig()
    with pytest.raises(RigError, match="none of the speech controls of rig blank; check `speech`"):
        solve(
            landmark_rig.rest[None],
            head_face(),
            landmark_rig,
            blank_rig(landmark_rig, speech=("x",)),
            landmark_rig.rest,
        )


def test_partners() -> None:
    landmark_rig = head_landmark_rig()
    names = landmark_rig.controls
    partner = control_partners(landmark_rig)
    assert names[partner[names.index("mouthSmileLeft")]] == "mouthSmileRight"
    assert names[partner[names.index("jawOpen")]] == "jawOpen"
    sides = landmark_partners(landmark_rig.rest)
    assert (sides[61], sides[13], sides[78]) == (291, 13, 308)


@pytest.mark.parametrize("turn", [np.eye(3), np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])])
def test_a_head_in_other_axes_and_units(turn: np.ndarray) -> None:
    head = load_head()
    moved = replace(head, vertices=100 * head.vertices @ turn, deltas=100 * head.deltas @ turn)
    landmark_rig = make_landmark_rig(moved, read_landmarks(load_rig("arkit").landmarks), head_face())
    np.testing.assert_allclose(landmark_rig.rest, head_landmark_rig().rest, atol=1e-6)
    np.testing.assert_allclose(landmark_rig.shapes, head_landmark_rig().shapes, atol=1e-6)


def test_a_slanted_head_is_said() -> None:
    head, slant = load_head(), np.radians(45)
    turn = np.array(
        [[np.cos(slant), np.sin(slant), 0.0], [-np.sin(slant), np.cos(slant), 0.0], [0.0, 0.0, 1.0]]
    )
    moved = replace(head, vertices=head.vertices @ turn)
    with pytest.raises(RigError, match="does not stand along the axes; turn it upright"):
        make_landmark_rig(moved, read_landmarks(load_rig("arkit").landmarks), head_face())


def test_coinciding_eyes_are_said() -> None:
    spots = read_landmarks(load_rig("arkit").landmarks)
    corners, weights = spots.corners.copy(), spots.weights.copy()
    corners[[362, 263]], weights[[362, 263]] = corners[[33, 133]], weights[[33, 133]]
    with pytest.raises(RigError, match="landmarks of the two eyes .* coincide"):
        make_landmark_rig(load_head(), replace(spots, corners=corners, weights=weights), head_face())


def test_descent_finds_the_bounded_minimum() -> None:
    rng = np.random.default_rng(6)
    root = rng.normal(size=(6, 4))
    gram, pull = root.T @ root, rng.normal(size=(7, 4))
    problem = Problem(gram, pull, np.zeros(4), np.ones(4), np.zeros(4), 0.0, np.array([7]))
    solved = descend(problem, np.zeros((7, 4)), sweeps=5000)
    slope = solved @ gram - pull  # Karush, Kuhn, Tucker: zero inside, pointing outwards at a bound
    inside = (solved > 0) & (solved < 1)
    assert np.abs(slope[inside]).max() < 1e-2
    assert (slope[solved == 0] >= -1e-2).all()
    assert (slope[solved == 1] <= 1e-2).all()


def test_a_fitted_rig_repeats_its_face() -> None:
    landmark_rig, face = head_landmark_rig(), head_face()
    rng = np.random.default_rng(7)
    controls = np.zeros((600, len(landmark_rig.controls)))
    for names, most in ((("jawOpen",), 0.4), (("mouthPucker",), 0.6), (("mouthLowerDown",), 0.4)):
        amount = most * np.clip(rng.normal(0.3, 0.5, 600), 0, 1)
        for name in names:
            controls += amount[:, None] * (posed(**{name: 1.0}) > 0)
    modes = face.project(landmark_rig.pose(controls))
    rig = fit_rig(blank_rig(landmark_rig), landmark_rig, face, modes)
    shapes, head = face.instance(modes), landmark_rig.pose(retarget(modes, face, rig, "direct"))
    assert rig.face == face.id
    assert rig.poses.shape == (8, 52)
    assert np.corrcoef(lip_aperture(shapes, face), lip_aperture(head, face))[0, 1] > 0.99
    assert np.corrcoef(lip_width(shapes, face), lip_width(head, face))[0, 1] > 0.97


def test_hinges_of_gaps_open_at_their_knots() -> None:
    face = head_face()
    names, loads, offsets = make_hinges(face)
    modes = np.random.default_rng(8).normal(size=(50, 5)) * face.std
    gap = lip_aperture(face.instance(modes), face)
    row = names.index("gap13>1mm")
    hinge = np.maximum(modes / face.std @ loads[row] + offsets[row], 0)
    np.testing.assert_allclose(hinge, np.maximum(gap - 1.0, 0) / 3.0, atol=1e-9)


def test_solving_is_a_way_to_retarget() -> None:
    face, rig = load_model("default").face, load_rig("arkit")
    modes = read_motion().modes(face)[:200]
    solved, direct = (retarget(modes, face, rig, how) for how in ("solve", "direct"))
    landmark_rig = make_landmark_rig(load_head(), shipped_landmarks(), face)
    posed = landmark_rig.pose(solved[:, [rig.controls.index(name) for name in landmark_rig.controls]])
    aperture, wanted = (lip_aperture(shapes, face) for shapes in (posed, face.instance(modes)))
    assert solved.shape == direct.shape
    assert np.corrcoef(aperture, wanted)[0, 1] > 0.99
    assert np.abs(solved - direct).max() > 0.01


def test_a_rig_without_a_head_cannot_be_solved() -> None:
    face = load_model("default").face
    with pytest.raises(RigError, match="rig vrm has no head to solve on; use --retarget auto"):
        retarget(np.zeros((1, len(face.std))), face, load_rig("vrm"), "solve")


def test_solving_keeps_up() -> None:
    face = load_model("default").face
    modes = read_motion().modes(face)
    landmark_rig = make_landmark_rig(load_head(), shipped_landmarks(), face)
    closed = closed_face(face, modes)
    started = time.perf_counter()
    solve(face.instance(modes), face, landmark_rig, load_rig("arkit"), closed)
    assert len(modes) / (time.perf_counter() - started) > 200  # frames per second; 10,000 when idle
