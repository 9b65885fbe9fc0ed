"""Shapes are found by the names of programs and conventions."""

import numpy as np
import pytest

from phonanim.errors import RigError
from phonanim.rig.fit_character import is_viseme
from phonanim.rig.morphs import Morphs, plain_name
from phonanim.rig.names import added_names, known_controls, read_names


def moved(shapes: tuple[str, ...], *channels: str) -> dict[str, list[tuple[str, float]]]:
    """The shapes and shares of each channel."""
    found: dict[str, list[tuple[str, float]]] = {name: [] for name in channels}
    for column, target, share in Morphs("hero.glb", 0, shapes).moved(channels):
        found[channels[column]].append((shapes[target], share))
    return found


@pytest.mark.parametrize(
    ("shapes", "control", "shape"),
    [
        (("vrc.v_aa", "vrc.v_pp"), "viseme_PP", "vrc.v_pp"),
        (("vrc.v_aa", "vrc.v_pp"), "aa", "vrc.v_aa"),
        (("Fcl_MTH_A", "Fcl_MTH_I"), "ih", "Fcl_MTH_I"),
        (("Face.M_F00_000_00_Fcl_MTH_A", "Face.M_F00_000_00_Fcl_MTH_O"), "oh", "Face.M_F00_000_00_Fcl_MTH_O"),
        (("あ", "う"), "ou", "う"),
        (("head__eCTRLvM", "head__eCTRLvF"), "viseme_PP", "head__eCTRLvM"),
        (
            ("Genesis8_1Male__facs_bs_MouthFunnel_div2",),
            "mouthFunnel",
            "Genesis8_1Male__facs_bs_MouthFunnel_div2",
        ),
        (("CTRL_expressions_mouthCornerPullL",), "mouthSmileLeft", "CTRL_expressions_mouthCornerPullL"),
        (("PP", "aa", "E"), "viseme_E", "E"),
        (("BS_aa", "BS_oh"), "oh", "BS_oh"),
        (("jawOpen_001", "x"), "jawOpen", "jawOpen_001"),
        (("Head_baseMesh.jawOpen.001",), "jawOpen", "Head_baseMesh.jawOpen.001"),
        (("mouth-open",), "jawOpen", "mouth-open"),
    ],
)
def test_a_control_finds_its_shape(shapes, control, shape):
    assert moved(shapes, control) == {control: [(shape, 1.0)]}


def test_a_control_moves_all_parts_of_its_shape():
    parts = ("Mouth_Funnel_Up_L", "Mouth_Funnel_Up_R", "Mouth_Funnel_Down_L", "Mouth_Funnel_Down_R")
    assert moved(parts, "mouthFunnel") == {"mouthFunnel": [(name, 1.0) for name in parts]}


def test_a_table_does_not_move_what_the_own_name_moves():
    assert moved(("jawOpen", "mouthOpen"), "jawOpen") == {"jawOpen": [("jawOpen", 1.0)]}
    elsewhere = Morphs("hero.glb", 1, ("mouthOpen",), present=frozenset(("jawOpen", "mouthOpen")))
    assert elsewhere.moved(("jawOpen",)) == []


def test_one_shape_closes_where_the_lips_close():
    values = np.array([[0.5, 0.1], [0.3, 0.3], [0.1, 0.2]], np.float32)
    weights = Morphs("", 0, ("mouthOpen",)).weights(values, ("jawOpen", "mouthClose"))
    np.testing.assert_allclose(weights[:, 0], [0.4, 0, 0], atol=1e-6)


def test_names_of_ones_own_win(tmp_path):
    table = tmp_path / "own.csv"
    table.write_text("shape,control,weight\nMund_auf,jawOpen,0.5\nspitz,mouthPucker,\n", encoding="utf-8")
    shapes = ("jawOpen", "Mund_auf", "spitz")
    with added_names(table):
        assert moved(shapes, "jawOpen", "mouthPucker") == {
            "jawOpen": [("Mund_auf", 0.5)],
            "mouthPucker": [("spitz", 1.0)],
        }
    assert moved(shapes, "jawOpen") == {"jawOpen": [("jawOpen", 1.0)]}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,control\na,b\n", r"own\.csv: cannot be read as a table of names: it has no column 'shape'"),
        ("shape,control,weight\na,jawOpen,2\n", r"own\.csv:2: is not a shape, a control and a weight"),
        ("shape,control,weight\na,jawOpen,nan\n", r"own\.csv:2"),
        ("shape,control\n,jawOpen\n", r"own\.csv:2"),
    ],
)
def test_wrong_tables_are_named_by_line(tmp_path, text, message):
    table = tmp_path / "own.csv"
    table.write_text(text, encoding="utf-8")
    with pytest.raises(RigError, match=message):
        read_names([table])


def test_short_names_need_no_guess():
    assert moved(("tongue_aa", "hand_E"), "aa", "viseme_E") == {"aa": [], "viseme_E": []}


def test_the_controls_that_a_shape_is():
    assert "visemepp" in known_controls("vrc.v_pp")
    assert plain_name("mouthClose") not in known_controls("mouthOpen")


@pytest.mark.parametrize(
    "name", ["eCTRLvAA", "Fcl_MTH_A", "vrc.v_oh", "あ", "viseme_PP", "aa", "Mund.viseme_U"]
)
def test_shapes_of_sounds_are_known_by_their_names(name: str) -> None:
    assert is_viseme(name)


@pytest.mark.parametrize("name", ["jawOpen", "mouthOpen", "Fcl_MTH_Angry", "Mouth_Funnel_Up_L", "smile"])
def test_other_shapes_are_no_visemes(name: str) -> None:
    assert not is_viseme(name)


@pytest.mark.parametrize(
    ("shapes", "control", "found"),
    [
        ("JawOpen MouthClosed", "mouthClose", {"MouthClosed": 1}),
        (
            "LipPuckerUpperLeft LipPuckerLowerRight",
            "mouthPucker",
            {"LipPuckerUpperLeft": 1, "LipPuckerLowerRight": 1},
        ),
        ("Jaw_Open Mouth_Pout", "mouthPucker", {"Mouth_Pout": 1}),
        (
            "JAW_DROP LIPS_TOWARD LIP_PUCKER_L LIP_PUCKER_R",
            "mouthPucker",
            {"LIP_PUCKER_L": 1, "LIP_PUCKER_R": 1},
        ),
        ("JAW_DROP LIPS_TOWARD", "mouthClose", {"LIPS_TOWARD": 1}),
        ("AU26 AU12_L AU12_R", "mouthSmileLeft", {"AU12_L": 1}),
        ("AU12 AU26", "mouthSmileLeft", {"AU12": 0.5}),
        ("MouthOpen MouthNarrow_Left Smile_Left", "mouthSmileLeft", {"Smile_Left": 1}),
        ("h_expressions.AE_AA_h h_expressions.MPB_Up_h", "viseme_PP", {"h_expressions.MPB_Up_h": 1}),
        ("blendShape1.AA_VI_10_aa blendShape1.AK_25_JawOpen", "viseme_aa", {"blendShape1.AA_VI_10_aa": 1}),
        ("JawOpen LipsFunnel LipsUpperUp", "mouthUpperUpRight", {"LipsUpperUp": 0.5}),
        ("Genesis8Female__eCTRLMouthOpen", "jawOpen", {"Genesis8Female__eCTRLMouthOpen": 1}),
        ("Open Explosive Tight-O", "viseme_PP", {"Explosive": 1}),
        ("ParamMouthOpenY ParamEyeLOpen", "jawOpen", {"ParamMouthOpenY": 1}),
        ("ｱ ｲ ｳ ｴ ｵ", "ou", {"ｳ": 1}),
        ("아 이 우 에 오", "oh", {"오": 1}),
        ("A I U E O", "ee", {"E": 1}),
        (
            "blendShape1.MTH_A blendShape1.MTH_I blendShape1.MTH_U blendShape1.MTH_E",
            "aa",
            {"blendShape1.MTH_A": 1},
        ),
        ("mouth_aa mouth_ih mouth_ou mouth_oh eye_blink", "oh", {"mouth_oh": 1}),
        ("mouthA mouthI mouthU mouthE mouthO", "ih", {"mouthI": 1}),
        ("jawOpen_BS mouthPucker_BS eyeBlink_L_BS", "eyeBlinkLeft", {"eyeBlink_L_BS": 1}),
        ("张嘴 微笑", "jawOpen", {"张嘴": 1}),
    ],
)
def test_names_of_other_programs_and_trackers(shapes, control, found):
    assert moved(tuple(shapes.split()), control) == {control: list(found.items())}


def test_three_short_names_behind_a_prefix_may_be_anything():
    assert moved(("arm_aa", "arm_oh", "arm_ou", "leg"), "aa") == {"aa": []}
