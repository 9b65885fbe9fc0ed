import numpy as np
import pytest

from phonanim.animation.style import scale_controls
from phonanim.errors import OptionError
from phonanim.rig import load_rig


@pytest.fixture(scope="module")
def rig():
    return load_rig("arkit")


@pytest.fixture
def values(rig):
    rng = np.random.default_rng(0)
    values = rng.uniform(rig.minimum, rig.maximum, (50, len(rig.controls))).astype(np.float32)
    for one, other in rig.at_most:
        values[:, one] = np.minimum(values[:, one], values[:, other])
    return values


def test_one_changes_nothing(rig, values):
    assert scale_controls(values, rig) is values


def test_nought_is_rest(rig, values):
    np.testing.assert_array_equal(scale_controls(values, rig, intensity=0.0), np.tile(rig.rest, (50, 1)))


def test_each_dial_moves_its_own_controls(rig, values):
    jaw = np.array([name.startswith("jaw") or name == "mouthClose" for name in rig.controls])
    lips = np.array([name.startswith("mouth") and name != "mouthClose" for name in rig.controls])
    for options, mine in (({"jaw": 0.5}, jaw), ({"lips": 0.5}, lips), ({"intensity": 0.5}, jaw | True)):
        changed = scale_controls(values, rig, **options)
        expected = np.where(mine, rig.rest + 0.5 * (values - rig.rest), values)
        np.testing.assert_allclose(changed, expected, atol=1e-6)


@pytest.mark.parametrize("options", [{"intensity": 3.0}, {"jaw": 4.0}, {"lips": 2.5, "intensity": 2.0}])
def test_limits_are_kept(rig, values, options):
    changed = scale_controls(values, rig, **options)
    assert (changed >= rig.minimum - 1e-6).all()
    assert (changed <= rig.maximum + 1e-6).all()


@pytest.mark.parametrize("options", [{"intensity": 0.3}, {"intensity": 3.0}, {"jaw": 2.0}, {"lips": 3.0}])
def test_what_one_control_allows_another_stays_allowed(rig, values, options):
    changed = scale_controls(values, rig, **options)
    for one, other in rig.at_most:
        assert (changed[:, one] <= changed[:, other] + 1e-6).all()


def test_a_share_of_the_jaw_is_not_scaled():
    rig = load_rig("metahuman")
    together = rig.controls.index("CTRL_expressions_mouthLipsTogetherUL")
    changed = scale_controls(np.ones((1, len(rig.controls)), np.float32), rig, intensity=0.5, jaw=0.5)
    assert changed[0, together] == 1.0
    assert changed[0, rig.controls.index("CTRL_expressions_jawOpen")] == 0.25


def test_drawn_mouths_are_not_scaled():
    rig = load_rig("rhubarb")
    values = np.eye(9, dtype=np.float32)
    assert scale_controls(values, rig, intensity=0.5, lips=2.0) is values


def test_a_gain_scales_its_control_alone(rig, values):
    changed = scale_controls(values, rig, own={"mouthFunnel": 0.5, "browInnerUp": 0.0})
    gains = np.ones(len(rig.controls))
    gains[rig.controls.index("mouthFunnel")] = 0.5
    gains[rig.controls.index("browInnerUp")] = 0.0
    np.testing.assert_allclose(changed, rig.rest + gains * (values - rig.rest), atol=1e-6)


@pytest.mark.parametrize("gain", [0.4, 1.2])
def test_closed_lips_stay_closed_when_the_jaw_has_a_gain(rig, values, gain):
    jaw, close = rig.controls.index("jawOpen"), rig.controls.index("mouthClose")
    values[:, jaw] = values[:, close] = np.linspace(0, 0.5, len(values))
    changed = scale_controls(values, rig, own={"jawOpen": gain})
    np.testing.assert_allclose(changed[:, jaw], gain * values[:, jaw], atol=1e-6)
    np.testing.assert_array_equal(changed[:, close], changed[:, jaw])
    alone = scale_controls(values, rig, own={"jawOpen": gain, "mouthClose": 0.2})
    np.testing.assert_allclose(alone[:, close], 0.2 * values[:, close], atol=1e-6)


def test_gains_multiply_and_keep_limits(rig, values):
    jaw = rig.controls.index("jawOpen")
    values[:, jaw] = np.linspace(0, 0.5, len(values))
    changed = scale_controls(values, rig, jaw=0.5, own={"jawOpen": 1.5})
    np.testing.assert_allclose(changed[:, jaw], 0.75 * values[:, jaw], atol=1e-6)
    assert scale_controls(values, rig, own={"jawOpen": 4.0})[:, jaw].max() == 1.0


def test_a_control_that_the_rig_lacks_is_named(rig, values):
    with pytest.raises(
        OptionError, match=r"gain jawOpn=1\.2: arkit has no such control; did you mean jawOpen\?"
    ):
        scale_controls(values, rig, own={"jawOpn": 1.2})
    with pytest.raises(OptionError, match="has no such control; `phonanim rig list` names the rigs"):
        scale_controls(values, rig, own={"xyzzy": 1.2})
