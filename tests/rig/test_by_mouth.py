"""Changes of one rig's controls as those of another that move the mouth alike."""

import numpy as np
import pytest

from phonanim.rig import load_rig
from phonanim.rig.by_mouth import mouth_matrix
from phonanim.rig.measures import MEASURES

JAW = MEASURES.index("jaw")


def moved(rig, weights):
    """Millimetres of each measure that changes of controls make."""
    first = [rig.controls.index(names[0]) for names in rig.mouth.names]
    return weights[first] @ rig.mouth.moved


@pytest.mark.parametrize("name", ["vrm", "oculus15"])
def test_a_jaw_opens_as_many_millimetres_on_a_rig_of_mouth_shapes(name):
    source, target = load_rig("arkit"), load_rig(name)
    matrix, shares = mouth_matrix(source, target)
    row = source.controls.index("jawOpen")
    wanted = source.mouth.moved[source.mouth.names.index(("jawOpen",)), JAW]
    assert moved(target, matrix[row])[JAW] == pytest.approx(wanted, rel=0.05)
    assert shares[row] > 0.99


def test_brows_and_mouths_that_are_drawn_have_no_share():
    source = load_rig("arkit")
    matrix, shares = mouth_matrix(source, load_rig("vrm"))
    row = source.controls.index("browInnerUp")
    assert shares[row] == 0
    assert not matrix[row].any()
    assert not mouth_matrix(source, load_rig("rhubarb"))[0].any()


def test_weights_of_visemes_keep_their_sum():
    matrix, _ = mouth_matrix(load_rig("arkit"), load_rig("oculus15"))
    np.testing.assert_allclose(matrix.sum(axis=1), 0, atol=1e-9)


def test_vowels_of_two_rigs_are_each_other():
    source, target = load_rig("oculus15"), load_rig("vrm")
    matrix, shares = mouth_matrix(source, target)
    for vowel, shape in (("viseme_aa", "aa"), ("viseme_O", "oh"), ("viseme_U", "ou")):
        row = source.controls.index(vowel)
        assert target.controls[int(matrix[row].argmax())] == shape
        assert shares[row] > 0.9
