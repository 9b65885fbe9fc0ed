"""Modes to controls: the paper's equations by hand, limits, and what may not go together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from faces import blank_rig, head_face, head_landmark_rig
from speech import track_of

from phonanim.errors import RigError
from phonanim.face.model import FaceModel
from phonanim.rig import HingeMap, Rig, load_rig, rig_names
from phonanim.rig.neck import TURNS
from phonanim.rig.retarget import retarget
from phonanim.rig.rig import POSES, Through


def toy_rig(**changes: object) -> Rig:
    """Two controls; mode 1 opens and closes the jaw, the negative side of mode 2 rounds the lips."""
    mean = np.array([0.2, 0.1])
    poses = np.tile(mean, (8, 1))
    poses[0] = [0.0, 0.1]
    poses[1] = [0.8, 0.1]
    poses[2] = [0.2, 0.7]
    facts = {
        "name": "toy",
        "title": "",
        "source": "",
        "controls": ("jaw", "round"),
        "minimum": np.zeros(2),
        "maximum": np.ones(2),
        "rest": np.zeros(2),
        "mean": mean,
        "poses": poses,
    }
    return Rig(**{**facts, **changes})


def toy_face() -> FaceModel:
    modes = np.eye(12)[:4].reshape(4, 4, 3)
    return FaceModel(np.zeros((4, 3)), modes, np.array([10.0, 4.0, 2.0, 1.0]), np.arange(4))


def test_equations_2_and_3_by_hand() -> None:
    # p_1 = 15 is half of +3 sigma_1 = 30: w = 0.5, jaw = 0.2 + 0.5 (0.8 - 0.2) = 0.5.
    # p_2 = -4 is a third of -3 sigma_2 = -12: w = 1/3, round = 0.1 + (0.7 - 0.1) / 3 = 0.3.
    values = retarget(np.array([[15.0, -4.0, 0.0, 0.0]]), toy_face(), toy_rig())
    np.testing.assert_allclose(values, [[0.5, 0.3]], atol=1e-6)


def test_a_positive_parameter_does_not_touch_the_negative_pose() -> None:
    values = retarget(np.array([[0.0, 4.0, 0.0, 0.0]]), toy_face(), toy_rig())
    np.testing.assert_allclose(values, [[0.2, 0.1]], atol=1e-6)


def slow_retarget(modes: np.ndarray, face: FaceModel, rig: Rig) -> np.ndarray:
    """Equations 2 and 3 as the paper writes them, number by number."""
    values = np.tile(rig.mean, (len(modes), 1))
    for frame, parameters in enumerate(modes):
        for k in range(4):
            for side, u in enumerate((-3.0, 3.0)):
                w = max(parameters[k] / (u * face.std[k]), 0.0)
                values[frame] += (rig.poses[2 * k + side] - rig.mean) * w
    return np.clip(values, rig.minimum, rig.maximum)


def test_poses_agree_with_the_slow_way() -> None:
    rng = np.random.default_rng(2)
    rig = toy_rig(poses=rng.uniform(0, 1, (8, 2)))
    modes = rng.normal(0, 8, (9000, 4))  # more frames than one block
    np.testing.assert_allclose(
        retarget(modes, toy_face(), rig), slow_retarget(modes, toy_face(), rig), atol=1e-5
    )


@pytest.mark.parametrize("how", ["poses", "direct"])
def test_the_mean_face_is_the_mean_pose(how: str) -> None:
    rig = toy_rig(direct=HingeMap(("mode1+",), np.eye(4)[:1], np.zeros(1), np.ones((1, 2)), toy_rig().mean))
    np.testing.assert_allclose(retarget(np.zeros((1, 4)), toy_face(), rig, how), [rig.mean], atol=1e-7)


def test_auto_prefers_the_direct_map() -> None:
    rig = toy_rig(direct=HingeMap(("mode1+",), np.eye(4)[:1], np.zeros(1), np.ones((1, 2)), np.zeros(2)))
    modes = np.array([[5.0, 0.0, 0.0, 0.0]])
    np.testing.assert_allclose(retarget(modes, toy_face(), rig), [[0.5, 0.5]])
    assert not np.allclose(retarget(modes, toy_face(), rig, "poses"), 0.5)


def test_values_keep_their_limits() -> None:
    rig = toy_rig(at_most=((1, 0),))
    values = retarget(np.random.default_rng(3).normal(0, 60, (500, 4)), toy_face(), rig)
    assert values.min() >= 0
    assert values.max() <= 1
    assert (values[:, 1] <= values[:, 0]).all()


def test_through_another_rig() -> None:
    through = Through(toy_rig(), np.array([[1.0, 1.0, 0.0], [0.0, 0.5, 0.0]]))
    three = {key: np.zeros(3) for key in ("minimum", "rest", "mean")}
    rig = toy_rig(
        controls=("a", "b", "c"),
        maximum=np.array([1, 0.6, 1]),
        through=through,
        poses=np.zeros((0, 3)),
        **three,
    )
    values = retarget(np.array([[15.0, -4.0, 0.0, 0.0]]), toy_face(), rig)
    np.testing.assert_allclose(values, [[0.5, 0.6, 0.0]], atol=1e-6)  # b = 0.5 + 0.3 / 2, limited


def test_a_share_of_another_control() -> None:
    """The second control is the share of "round" in "jaw"; a jaw of less than a hundredth counts as that."""
    shares = ((1, 1, 0),)
    rig = toy_rig(through=Through(toy_rig(), np.array([[1.0, 0.0], [0.0, 0.0]]), shares))
    modes = np.array([[15.0, -4.0, 0.0, 0.0], [-30.0, -0.1, 0.0, 0.0]])
    direct = retarget(modes, toy_face(), toy_rig())
    assert direct[1, 0] < 0.01 < direct[0, 0]
    values = retarget(modes, toy_face(), rig)
    expected = [[direct[0, 0], direct[0, 1] / direct[0, 0]], [direct[1, 0], min(1, direct[1, 1] / 0.01)]]
    np.testing.assert_allclose(values, expected, atol=1e-6)


def test_a_head_is_needed_to_solve() -> None:
    with pytest.raises(RigError, match="rig toy has no head to solve on; use --retarget auto"):
        retarget(np.zeros((1, 4)), toy_face(), toy_rig(), "solve")


def test_accents_and_tongue_come_with_the_phones() -> None:
    rig, face = shipped_arkit()
    rig = replace(rig, tongue=None)
    tongue = load_rig("arkit_tongue")
    assert tongue.through is not None
    tongue = replace(tongue, face="", through=replace(tongue.through, rig=rig))
    track, times = track_of("sil 0.2 th 0.2 sh 0.2 sil 0.2"), np.arange(20) / 25
    modes = np.zeros((20, len(face.std)))
    plain = retarget(modes, face, rig)
    assert np.array_equal(retarget(modes, face, rig, track=track), plain)
    assert np.array_equal(retarget(modes, face, rig, track=track, times=times, accents=False), plain)
    assert not np.array_equal(retarget(modes, face, rig, track=track, times=times), plain)
    placed = retarget(modes, face, tongue, track=track, times=times, accents=False)
    assert not np.array_equal(placed, retarget(modes, face, tongue))


def test_no_frames() -> None:
    assert retarget(np.zeros((0, 4)), toy_face(), toy_rig()).shape == (0, 2)


def test_another_face_is_refused() -> None:
    with pytest.raises(RigError, match="made for the reference face 012345.*fit the rig again"):
        retarget(np.zeros((1, 4)), toy_face(), toy_rig(face="012345"))


def test_no_direct_map_is_said() -> None:
    with pytest.raises(RigError, match="rig toy has no direct map; use --retarget poses"):
        retarget(np.zeros((1, 4)), toy_face(), toy_rig(), "direct")


def test_no_poses_is_said() -> None:
    with pytest.raises(RigError, match="rig toy has no poses; use --retarget direct"):
        retarget(np.zeros((1, 4)), toy_face(), toy_rig(poses=np.zeros((0, 2))), "poses")


@pytest.mark.parametrize("name", rig_names())
def test_shipped_rigs_are_whole(name: str) -> None:
    rig = load_rig(name)
    assert rig.title
    assert rig.source
    assert (rig.minimum <= rig.rest).all()
    assert (rig.rest <= rig.maximum).all()
    assert rig.posed or rig.direct or rig.through or rig.visemes or rig.articulated


def shipped_arkit() -> tuple[Rig, FaceModel]:
    """The ARKit preset with a face of as many modes; only its standard deviations matter here."""
    rig = load_rig("arkit")
    count = rig.direct.loads.shape[1]
    face = FaceModel(np.zeros((6, 3)), np.eye(18)[:count].reshape(count, 6, 3), np.ones(count), np.arange(6))
    return replace(rig, face=""), face


@pytest.mark.parametrize("how", ["poses", "direct"])
def test_arkit_is_symmetric(how: str) -> None:
    rig, face = shipped_arkit()
    values = retarget(np.random.default_rng(4).normal(size=(200, len(face.std))), face, rig, how)
    for column, name in enumerate(rig.controls):
        if name.endswith("Left") and name.startswith("mouth") and name != "mouthLeft":
            other = rig.controls.index(name.removesuffix("Left") + "Right")
            np.testing.assert_allclose(values[:, column], values[:, other], atol=1e-6)


@pytest.mark.parametrize("how", ["poses", "direct"])
def test_arkit_keeps_mouth_close_below_jaw_open(how: str) -> None:
    rig, face = shipped_arkit()
    values = retarget(np.random.default_rng(5).normal(0, 2, (2000, len(face.std))), face, rig, how)
    close, jaw = (values[:, rig.controls.index(name)] for name in ("mouthClose", "jawOpen"))
    assert (close <= jaw).all()
    assert close.max() > 0.1


def test_every_pose_has_its_place() -> None:
    rig = load_rig("arkit")
    opened, pressed = (rig.poses[list(POSES).index(name)] for name in ("mode1_plus", "mode1_minus"))
    jaw = rig.controls.index("jawOpen")
    assert opened[jaw] > rig.mean[jaw] > pressed[jaw]


def test_toy_rig_is_the_shipped_head() -> None:
    assert (*blank_rig(head_landmark_rig()).controls, *TURNS) == load_rig("arkit").controls
    assert head_face().modes.shape == (5, 478, 3)
