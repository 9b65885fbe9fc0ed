"""A face is found from a few points that a person marks, whatever its shapes are called."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from phonanim.errors import RigError
from phonanim.face.model import INNER_LIP_PAIRS
from phonanim.pipeline import load_model
from phonanim.rig.face_points import complete_landmarks, face_points
from phonanim.rig.fit_character import fit_character
from phonanim.rig.head import TONGUE, Head, load_head
from phonanim.rig.landmarks import MeshLandmarks, shipped_landmarks

TURN = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # a head that lies, in centimetres
POINTS = [point.landmark for point in face_points()]
NEEDED = [point.landmark for point in face_points() if point.needed]


def nameless() -> Head:
    """The shipped head, lying and in centimetres, with shapes whose names say nothing."""
    head = load_head().without(TONGUE)
    names = tuple(f"shape{row}" for row in range(len(head.targets)))
    return replace(head, targets=names, vertices=head.vertices @ TURN * 100, deltas=head.deltas @ TURN * 100)


def errors(found: MeshLandmarks) -> dict[int, float]:
    """How far landmarks lie from where they are on the shipped head, mm by number."""
    spots, points = shipped_landmarks(), load_head().vertices
    apart = np.linalg.norm(found.of(points) - spots.take(found.numbers).of(points), axis=1) * 1000
    return dict(zip(found.numbers.tolist(), apart.tolist(), strict=True))


@pytest.mark.parametrize("marked", [POINTS, NEEDED], ids=["fifteen", "ten"])
def test_all_landmarks_are_found_from_a_few(marked):
    given = shipped_landmarks().take(marked)
    found = errors(complete_landmarks(load_head(), shipped_landmarks(), nameless(), given))
    assert len(found) == 478
    assert max(found[number] for number in marked) < 1e-6
    assert np.median(list(found.values())) < 1.0
    assert max(found[number] for pair in INNER_LIP_PAIRS for number in pair) < 2.5


def test_lips_marked_as_one_are_parted():
    """In a closed mouth, a click for the lower lip may meet the upper one."""
    given = shipped_landmarks().take(NEEDED)
    upper, lower = NEEDED.index(13), NEEDED.index(14)
    corners, weights = given.corners.copy(), given.weights.copy()
    corners[lower], weights[lower] = corners[upper], weights[upper]
    wrong = MeshLandmarks(given.numbers, corners, weights)
    head = load_head().without(TONGUE)
    assert errors(complete_landmarks(load_head(), shipped_landmarks(), head, wrong))[14] < 2.5


def test_a_rig_is_fitted_to_a_head_without_known_names():
    rig, spots = fit_character(nameless(), load_model("default").face, "x", shipped_landmarks().take(POINTS))
    assert len(spots.numbers) == 478
    assert rig.mouth is not None
    moved = {name for names in rig.mouth.names for name in names}
    jaw = load_head().without(TONGUE).targets.index("jawOpen")
    assert f"shape{jaw}" in moved


def test_points_that_cannot_be_are_refused():
    head, spots = load_head().without(TONGUE), shipped_landmarks()
    with pytest.raises(RigError, match=r"lacks 152 \(chin, lowest point\); mark it: phonanim rig landmarks"):
        complete_landmarks(load_head(), spots, head, spots.take(NEEDED[:-1]))
    given = spots.take(NEEDED)
    far = MeshLandmarks(given.numbers, given.corners + len(head.vertices), given.weights)
    with pytest.raises(RigError, match=r"names vertex \d+, and the head has \d+; mark the points on this"):
        complete_landmarks(load_head(), spots, head, far)
    corners = given.corners.copy()
    corners[NEEDED.index(152)] = given.corners[NEEDED.index(33)]  # an eye for a chin
    with pytest.raises(RigError, match=r"landmark 152 \(chin, lowest point\) lies \d+ mm from its place"):
        complete_landmarks(load_head(), spots, head, MeshLandmarks(given.numbers, corners, given.weights))
    one = MeshLandmarks(given.numbers, given.corners * 0, given.weights)
    with pytest.raises(RigError, match="the marked points coincide; mark them anew"):
        complete_landmarks(load_head(), spots, head, one)
