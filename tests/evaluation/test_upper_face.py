import numpy as np
import pytest

from phonanim.animation.animation import Animation
from phonanim.evaluation.scoring import Settings, score, without_turns
from phonanim.evaluation.upper_face import rises, upper_face_measures
from phonanim.pipeline import animate


def take(**curves):
    values = np.stack(list(curves.values()), axis=1).astype(np.float32)
    return Animation(values, tuple(curves), 30.0, "arkit")


def lively(blinks=10, yaw=2.0):
    """A minute with so many blinks and brow raises."""
    times = np.arange(1800) / 30
    lids = (times * blinks / 60 % 1 > 0.9).astype(float)
    return take(
        jawOpen=0.5 + 0.4 * np.sin(times),
        eyeBlinkLeft=lids,
        eyeBlinkRight=lids,
        browInnerUp=0.2 * lids,
        eyeLookOutLeft=np.clip(np.sin(times), 0, 1),
        eyeLookInLeft=np.clip(-np.sin(times), 0, 1),
        eyeLookInRight=np.clip(np.sin(times), 0, 1),
        eyeLookOutRight=np.clip(-np.sin(times), 0, 1),
        headYaw=yaw * np.sqrt(2) * np.sin(np.pi * times),
    )


def test_statistics_of_a_take():
    found = upper_face_measures(lively())
    assert found["blinks_per_min"] == found["brow_raises_per_min"] == pytest.approx(10)
    assert found["gaze_sd_deg"] == pytest.approx(25 / np.sqrt(2), rel=0.02)
    assert found["head_sd_deg"] == pytest.approx(2.0, rel=0.01)
    assert upper_face_measures(take(jawOpen=np.zeros(30))) == {}


def test_a_curve_passes_a_threshold():
    assert rises(np.array([0, 1, 1, 0, 1.0]), 0.5) == 2


def test_a_score_has_them_of_both_sides_and_leaves_degrees_out_of_errors():
    measures = score(lively(), lively(6, yaw=20.0), Settings()).measures
    assert measures["blinks_per_min"] == pytest.approx(10)
    assert measures["captured_blinks_per_min"] == pytest.approx(6)
    assert measures["captured_head_sd_deg"] == pytest.approx(20.0, rel=0.01)
    assert measures["control_mse"] < 0.1
    assert "headYaw" not in without_turns(lively()).channels


def test_what_life_adds_to_a_line_is_above_the_mouth(line_without_sound):
    on, off = (animate(line_without_sound, life=life, fps=25) for life in (1.0, 0.0))
    found = score(off, on, Settings()).measures
    assert found["fdd_mm"] > 0.1
    assert found["captured_blinks_per_min"] > found["blinks_per_min"] == 0
    for name in ("lve_mm", "tmve_mouth_mm", "tmve_jaw_mm"):
        assert found[name] < 0.01
    assert found["aperture_r"] > 0.9999
