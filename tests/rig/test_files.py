"""Rig files: what is written is read again, and every mistake is named with its mend."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from faces import head_face

from phonanim.errors import RigError
from phonanim.rig import load_rig
from phonanim.rig.landmarks import HEADER, read_landmarks, write_landmarks
from phonanim.rig.motion import Motion, read_motion, sample_motion, write_motion
from phonanim.rig.read import read_document, rig_problems
from phonanim.rig.rig import POSES
from phonanim.rig.tables import read_hinges, read_mixture, write_hinges
from phonanim.rig.write import rig_text, write_rig

CONTROLS = "[controls]\njaw = [0.0, 0.1, 1.0]\nround = [0.0, 0.0, 1.0]\n"
POSED = "".join(f"[poses.{pose}]\njaw = 0.5\n" for pose in POSES)


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_minimal_rig(tmp_path: Path) -> None:
    rig = load_rig(str(written(tmp_path, CONTROLS + POSED)))
    assert rig.name == "mine"
    assert rig.controls == ("jaw", "round")
    assert rig.rest.tolist() == [0.1, 0.0]
    assert rig.mean.tolist() == [0.1, 0.0]  # unnamed controls rest
    assert rig.poses.tolist() == [[0.5, 0.0]] * 8


def test_the_shipped_rig_is_read_as_written(tmp_path: Path) -> None:
    rig = load_rig("arkit")
    write_rig(tmp_path / "arkit.toml", replace(rig, head=None, landmarks=None))
    again = load_rig(str(tmp_path / "arkit.toml"))
    for field in ("minimum", "maximum", "rest", "mean", "poses"):
        np.testing.assert_allclose(getattr(again, field), getattr(rig, field), atol=0.005)
    for field in ("name", "source", "controls", "speech", "at_most", "face"):
        assert getattr(again, field) == getattr(rig, field)
    np.testing.assert_allclose(again.direct.weights, rig.direct.weights, atol=1e-5)


def test_poses_say_what_they_look_like() -> None:
    text = rig_text(load_rig("arkit"), Path())
    for pose, looks in POSES.items():
        assert f"[poses.{pose}]  # {looks}" in text


def test_awkward_names_are_quoted(tmp_path: Path) -> None:
    rig = load_rig(
        str(
            written(
                tmp_path, CONTROLS.replace("jaw", '"mund öffnen"') + POSED.replace("jaw", '"mund öffnen"')
            )
        )
    )
    write_rig(tmp_path / "again.toml", rig)
    assert load_rig(str(tmp_path / "again.toml")).controls == ("mund öffnen", "round")


MISTAKES = {
    "misspelt control": (
        CONTROLS + POSED.replace("jaw", "jwa", 1),
        "[poses.mode1_minus] names the control 'jwa', which is not in [controls]; did you mean 'jaw'?",
    ),
    "outside limits": (
        CONTROLS + POSED.replace("0.5", "1.5", 1),
        "[poses.mode1_minus] jaw = 1.5 is outside its limits 0.0 to 1.0; change one of them",
    ),
    "not a number": (
        CONTROLS + POSED.replace("0.5", "'much'", 1),
        "[poses.mode1_minus] jaw must be a number, not 'much'",
    ),
    "NaN": (CONTROLS + POSED.replace("0.5", "nan", 1), "[poses.mode1_minus] jaw must be a number, not nan"),
    "pose missing": (
        CONTROLS + POSED.replace("[poses.mode2_plus]\njaw = 0.5\n", ""),
        "[poses.mode2_plus] is missing: mouth broad, upper lip raised",
    ),
    "pose misspelt": (
        CONTROLS + POSED + "[poses.mode5_plus]\njaw = 0.5\n",
        "[poses.mode5_plus] is not a pose; did you mean 'mode4_plus'?",
    ),
    "unknown key": ("contrls = 3\n" + CONTROLS + POSED, "unknown key 'contrls'; did you mean 'controls'?"),
    "no controls": ("name = 'x'\n", "needs a table [controls] with name = [minimum, rest, maximum]"),
    "limits crossed": (
        "[controls]\njaw = [1.0, 0.0, 0.0]\n",
        "[controls] jaw = [1.0, 0.0, 0.0]: must rise from minimum over rest to maximum",
    ),
    "limits not three": (
        "[controls]\njaw = [1.0]\n",
        "[controls] jaw must be [minimum, rest, maximum], three numbers, not [1.0]",
    ),
    "at_most unknown": (
        CONTROLS + "[at_most]\nround = 'jae'\n" + POSED,
        "[at_most] names the control 'jae', which is not in [controls]; did you mean 'jaw'?",
    ),
    "speech unknown": ("speech = ['juw']\n" + CONTROLS + POSED, "[speech] names the control 'juw'"),
    "nothing to move it": (CONTROLS, "needs [poses.*], a direct map, visemes, or a rig to go through"),
    "not TOML": ("[controls", "is not TOML"),
    "through without table": ("through = 'arkit'\n" + CONTROLS, "goes through 'arkit' and so needs a table"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_are_named_with_their_mend(name: str, tmp_path: Path) -> None:
    text, message = MISTAKES[name]
    path = written(tmp_path, text)
    with pytest.raises(RigError) as caught:
        load_rig(str(path))
    assert message in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_all_problems_are_found_at_once(tmp_path: Path) -> None:
    path = written(tmp_path, CONTROLS + "[poses.mean]\njwa = 0.5\nround = 7.0\n")
    assert len(rig_problems(read_document(path))) == 2 + len(POSES)
    with pytest.raises(RigError, match=r"and 9 more: phonanim rig check"):
        load_rig(str(path))


def test_an_unknown_name_gets_the_nearest() -> None:
    with pytest.raises(RigError, match="there is no rig 'arkti'; did you mean 'arkit'.*phonanim rig new"):
        load_rig("arkti")


def test_bytes_that_are_no_text_are_said(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(RigError, match="it is not UTF-8 text"):
        load_rig(str(path))


def test_a_folder_is_no_rig(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="cannot be read"):
        read_document(tmp_path)


# Tables.


def test_hinges_are_read_as_written(tmp_path: Path) -> None:
    rig = load_rig("arkit")
    write_hinges(tmp_path / "a.csv", rig.direct, rig.controls)
    again = read_hinges(tmp_path / "a.csv", rig.controls)
    assert again.names == rig.direct.names
    np.testing.assert_allclose(again.loads, rig.direct.loads, atol=1e-5)
    np.testing.assert_allclose(again.base, rig.direct.base, atol=1e-5)


HINGES = "hinge,offset,mode1,jaw\nbase,,,0.1\nmode1+,,1,0.2\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "needs a header and a row per line"),
        (
            HINGES.replace("hinge", "hing"),
            "needs the columns hinge, offset, mode1 ... and a first row 'base'",
        ),
        (HINGES.replace("base", "bass"), "needs the columns hinge, offset, mode1 ... and a first row 'base'"),
        (HINGES.replace("jaw", "jow"), "names the control 'jow', which the rig does not have"),
        (HINGES.replace("0.2", "x"), "line 3: could not convert string to float: 'x'; write a number"),
        (HINGES.replace("0.2", "nan"), "holds a value that is not finite"),
        (HINGES.replace("0.2", "0.2,1"), "line 3: has 5 cells, the header 4"),
    ],
)
def test_hinge_mistakes(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RigError) as caught:
        read_hinges(path, ("jaw",))
    assert message in str(caught.value)


def test_mixtures(tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    path.write_text("from,to,weight\na,y,0.5\nb,x,1\n", encoding="utf-8")
    np.testing.assert_array_equal(read_mixture(path, ("a", "b"), ("x", "y")), [[0, 0.5], [1, 0]])
    path.write_text("from,too,weight\na,y,0.5\n", encoding="utf-8")
    with pytest.raises(RigError, match="needs the columns from, to, weight"):
        read_mixture(path, ("a", "b"), ("x", "y"))


def test_missing_tables_are_said(tmp_path: Path) -> None:
    with pytest.raises(RigError, match=r"gone\.csv: cannot be read"):
        read_mixture(tmp_path / "gone.csv", (), ())
    with pytest.raises(RigError, match=r"gone\.csv: cannot be read"):
        read_landmarks(tmp_path / "gone.csv")


# Landmarks.


def test_landmarks_are_read_as_written(tmp_path: Path) -> None:
    spots = read_landmarks(load_rig("arkit").landmarks)
    write_landmarks(tmp_path / "l.csv", spots)
    again = read_landmarks(tmp_path / "l.csv")
    np.testing.assert_array_equal(again.corners, spots.corners)
    np.testing.assert_allclose(again.weights, spots.weights, atol=1e-4)
    np.testing.assert_allclose(again.weights.sum(axis=1), 1, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n", "must begin with the header landmark,vertex_a"),
        (",".join(HEADER) + "\n1,2,3,4,x,0,0\n", "line 2: weight_a is 'x'; it is a number from 0 to"),
        (
            ",".join(HEADER) + "\n1,2,3,4,0.5,0,0\n",
            "line 2: needs a landmark, three vertices and three weights",
        ),
    ],
)
def test_landmark_mistakes(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "l.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RigError) as caught:
        read_landmarks(path)
    assert message in str(caught.value)


def test_a_landmark_that_is_not_there_is_said() -> None:
    with pytest.raises(RigError, match="no landmark 999; add its row to the landmark table"):
        read_landmarks(load_rig("arkit").landmarks).take([13, 999])


# The motion sample.


def test_the_shipped_motion_is_that_of_the_preset() -> None:
    motion, rig = read_motion(), load_rig("arkit")
    assert motion.face == rig.face
    assert motion.standardized.shape[1] == rig.direct.loads.shape[1]
    assert np.abs(motion.standardized).max() < 8


def test_motion_is_read_as_written(tmp_path: Path) -> None:
    face = head_face()
    modes = np.random.default_rng(1).normal(size=(400, 5)) * face.std
    modes[::2] = face.project(face.mean[None]) - [[40.0, 0, 0, 0, 0]]
    motion = sample_motion(modes, face, 100, np.random.default_rng(2))
    write_motion(tmp_path / "m.csv", motion)
    again = read_motion(tmp_path / "m.csv")
    assert again.face == face.id
    np.testing.assert_array_equal(again.standardized, motion.standardized)
    assert again.modes(face).shape == (100, 5)


def test_motion_of_another_face_is_refused() -> None:
    with pytest.raises(RigError, match=r"is of the reference face abc, .* rebuild it"):
        Motion("abc", np.zeros((1, 5))).modes(head_face())


def test_a_damaged_motion_is_said(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text("face a,mode1\n1,x\n", encoding="utf-8")
    with pytest.raises(RigError, match="is not a motion sample"):
        read_motion(tmp_path / "m.csv")
