"""Controls of one rig as those of another."""

import numpy as np
import pytest

from phonanim.pipeline import animate
from phonanim.rig import load_rig
from phonanim.rig.between import control_matrix, convert_controls


@pytest.fixture(scope="module")
def values(line_without_sound):
    return animate(line_without_sound, rig="arkit", fps=25).values


def test_there_and_back_through_a_table(values):
    arkit, metahuman = load_rig("arkit"), load_rig("metahuman")
    there, lost = convert_controls(values, arkit, metahuman)
    assert lost == ()
    back, lost = convert_controls(there, metahuman, arkit)
    assert lost == ()
    np.testing.assert_allclose(back, values, atol=1e-3)  # lips that close among them, by their shares


def test_what_has_no_place_is_named(values):
    arkit, mediapipe = load_rig("arkit"), load_rig("mediapipe")
    there, lost = convert_controls(values, arkit, mediapipe)
    assert "headYaw" in lost
    assert there.shape[1] == len(mediapipe.controls)
    across, lost = convert_controls(there, mediapipe, load_rig("metahuman"))
    assert lost == ()
    assert across.shape[1] == len(load_rig("metahuman").controls)


def test_a_matrix_leads_only_where_a_table_does():
    arkit, metahuman = load_rig("arkit"), load_rig("metahuman")
    matrix = control_matrix(arkit, metahuman)
    row, column = arkit.controls.index("jawOpen"), metahuman.controls.index("CTRL_expressions_jawOpen")
    assert matrix[row, column] == 1
    assert control_matrix(metahuman, arkit)[column, row] == pytest.approx(1)
    assert control_matrix(arkit, load_rig("vrm")) is None
    np.testing.assert_array_equal(control_matrix(metahuman, metahuman), np.eye(len(metahuman.controls)))
