import numpy as np
import pytest

from phonanim.errors import OptionError
from phonanim.life import life_of
from phonanim.life.emotion import emotion_names, emotion_offsets, emotion_pose, weight
from phonanim.options import Emotion, Options
from phonanim.pipeline import animate, animate_detailed
from phonanim.rig import load_rig

ALONE = {"life": 0.0}


@pytest.fixture(scope="module")
def line(line_without_sound):
    return line_without_sound


def test_every_emotion_is_a_pose_of_arkit():
    rig = load_rig("arkit")
    names = [name.lower() for name in rig.controls]
    assert set(emotion_names()) == {"anger", "disgust", "fear", "joy", "sadness", "surprise"}
    for name in emotion_names():
        assert set(emotion_pose(name)) <= set(names), name
        assert all(0 < value <= 1 for value in emotion_pose(name).values())


def test_one_emotion_goes_into_the_next():
    times = np.arange(0, 6, 0.01)
    joy, anger = Emotion("joy", 1.0, (1.0, 3.0)), Emotion("anger", 1.0, (3.0, 5.0))
    both = weight(joy, times) + weight(anger, times)
    np.testing.assert_allclose(both[(times > 1.4) & (times < 4.6)], 1.0, atol=1e-9)
    assert weight(joy, np.array([0.6, 3.4])).tolist() == [0.0, 0.0]
    assert weight(Emotion("joy", 0.4), times).tolist() == [0.4] * len(times)


def test_of_several_spans_of_one_emotion_the_most_shows():
    rig, times = load_rig("arkit"), np.array([1.0, 2.0])
    spans = (Emotion("joy", 0.2), Emotion("joy", 0.5, (1.5, 9.0)))
    smile = emotion_offsets(spans, rig, times)[:, rig.controls.index("mouthSmileLeft")]
    np.testing.assert_allclose(smile, np.array([0.2, 0.5]) * emotion_pose("joy")["mouthsmileleft"])


def test_lips_win_and_closures_stay_whole(line):
    options = {"rig": "arkit", "fps": 60.0, **ALONE}
    plain = animate_detailed(line, Options(**options))
    moved = animate(line, Options(**options, emotions=(Emotion("joy"), Emotion("surprise", 0.7, (1.0, 3.0)))))
    track, times = plain.track, plain.animation.times
    from phonanim.speech.inventory import INVENTORY

    names = np.array(INVENTORY.phones)[track.sample(times)]
    shut = np.isin(names, ["p", "b", "m", "f", "v"])
    mouth = [i for i, name in enumerate(moved.channels) if name.startswith(("mouth", "jaw"))]
    np.testing.assert_array_equal(moved.values[shut][:, mouth], plain.animation.values[shut][:, mouth])
    smile = moved.channel("mouthSmileLeft") - plain.animation.channel("mouthSmileLeft")
    spoken = names != "sil"
    assert 0.1 < smile[spoken].max() < 0.5 * emotion_pose("joy")["mouthsmileleft"] + 1e-6
    assert moved.channel("cheekSquintLeft").max() > 0.5


def test_a_rig_without_a_control_for_it_says_so(line):
    notes = animate(line, Options(rig="vrm", emotions=(Emotion("joy"),))).provenance["notes"]
    assert "vrm has no control for any of the emotions, so it shows none" in notes
    notes = animate(line, Options(rig="vrm", blinks=1, look_at=(0, 0, 1))).provenance["notes"]
    assert notes == [
        "vrm has no control that blinks, so blinks have no effect",
        "vrm has no eyes that turn, so gaze has no effect",
    ]


def test_names_that_are_none():
    with pytest.raises(OptionError, match="there is no emotion 'glee'; choose anger"):
        life_of(Options(emotions=(Emotion("glee"),)), "line")
    with pytest.raises(OptionError, match="there is no behaviour 'brow'; did you mean brows"):
        life_of(Options(life={"brow": 1.0}), "line")
