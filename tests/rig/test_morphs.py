import numpy as np
import pytest
from animations import line

from phonanim.errors import RigError
from phonanim.media.glb import Glb
from phonanim.rig.morphs import Morphs, find_morphs, plain_name


@pytest.mark.parametrize(
    "name", ["jawOpen", "JawOpen", "jaw_open", "head.jawOpen", "blendShape1.JawOpen", "Jaw Open"]
)
def test_names_that_programs_change_read_the_same(name):
    assert plain_name(name) == plain_name("jawOpen")


@pytest.mark.parametrize(
    "name", ["eyeBlinkLeft", "eyeBlink_L", "EyeBlinkL", "eye_blink_l", "face.eyeBlink_L", "eyeBlink.L"]
)
def test_sides_are_spelt_out(name):
    assert plain_name(name) == plain_name("eyeBlinkLeft") != plain_name("eyeBlinkRight")


def test_names_that_end_in_a_letter_of_a_side():
    assert plain_name("mouthRoll") == "mouthroll"
    assert plain_name("aaR") == "aaright"
    assert plain_name("L") == "l"


def test_the_exact_name_wins_and_doubt_is_an_error():
    morphs = Morphs("a.glb", 0, ("jawOpen", "JawOpen", "x.smile", "y.smile"))
    assert morphs.moved(("jawOpen",)) == [(0, 0, 1.0)]
    assert morphs.moved(("unknown",)) == []
    with pytest.raises(
        RigError, match=r"a\.glb: the channel smile fits two morph targets, 'x\.smile' and 'y\.sm"
    ):
        morphs.moved(("smile",))


def test_weights_are_channels_by_name():
    animation = line(3)
    weights = Morphs("", 0, ("other", "jawOpen", "")).weights(animation.values, animation.channels)
    np.testing.assert_allclose(weights[:, 1], animation.channel("jawOpen"))
    assert not weights[:, [0, 2]].any()


def character(extensions):
    targets = [{}, {}, {}]
    meshes = [
        {"primitives": [{}]},
        {"primitives": [{"targets": targets, "extras": {"targetNames": ["a", "b", "c"]}}]},
    ]
    return Glb(
        {"meshes": meshes, "nodes": [{"mesh": 0}, {}, {"mesh": 1}], "extensions": extensions}, b"", "a.vrm"
    )


def test_vrm_1_expressions():
    binds = [{"node": 2, "index": 1, "weight": 0.5}, {"node": 2, "index": 2}]
    found = find_morphs(
        character({"VRMC_vrm": {"expressions": {"preset": {"aa": {"morphTargetBinds": binds}}}}})
    )
    assert [morphs.node for morphs in found] == [2]
    assert found[0].moved(("aa", "a")) == [(0, 1, 0.5), (0, 2, 1.0), (1, 0, 1.0)]


def test_vrm_0_groups():
    groups = [
        {"presetName": "o", "name": "O", "binds": [{"mesh": 1, "index": 0, "weight": 80}]},
        {"presetName": "unknown", "name": "tongueOut", "binds": [{"mesh": 1, "index": 2, "weight": 100}]},
    ]
    (found,) = find_morphs(character({"VRM": {"blendShapeMaster": {"blendShapeGroups": groups}}}))
    assert found.moved(("oh", "tongueOut")) == [(0, 0, 0.8), (1, 2, 1.0)]


def test_a_character_without_targets():
    with pytest.raises(
        RigError, match=r"a\.glb: has no morph targets; export the character with its shape keys"
    ):
        find_morphs(Glb({"meshes": [{"primitives": [{}]}], "nodes": [{"mesh": 0}]}, b"", "a.glb"))
