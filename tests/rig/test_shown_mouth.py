"""What controls show on a rig's own head."""

from __future__ import annotations

import numpy as np
import pytest

from phonanim.articulation import CHANNELS, Articulation
from phonanim.pipeline import load_model
from phonanim.rig import load_rig
from phonanim.rig.pronounce import pronounce
from phonanim.rig.shown_mouth import TONGUE, show_mouth, shown_mouth

WANTED = {"jaw": 5.0, "lip_gap": 9.0, "lower_lip_to_teeth": 7.0}


@pytest.mark.parametrize("name", ["arkit", "metahuman", "mediapipe"])
def test_rigs_that_go_through_arkit_show_what_it_shows(name: str) -> None:
    arkit, rig, face = load_rig("arkit"), load_rig(name), load_model("default").face
    assert arkit.mouth is not None
    row = np.array([[WANTED.get(channel, 0.0) for channel in CHANNELS]])
    values = pronounce(Articulation(row), arkit, arkit.mouth)
    if rig.through is not None:
        table = rig.through.table
        shares = [(own, values[:, a] / values[:, b]) for own, a, b in rig.through.shares]
        values = (values @ table).astype(np.float32)
        for own, share in shares:
            values[:, own] = share
    shown = show_mouth(rig, values, face)
    assert shown is not None
    assert shown["jaw"][0] == pytest.approx(5.0, abs=0.1)
    assert shown["lip_gap"][0] == pytest.approx(9.0, abs=0.8)


@pytest.mark.parametrize("name", ["vrm", "oculus15"])
def test_shapes_open_the_shipped_head(name: str) -> None:
    rig, face = load_rig(name), load_model("default").face
    opened = rig.controls.index({"vrm": "aa", "oculus15": "viseme_aa"}[name])
    shown = show_mouth(rig, np.eye(len(rig.controls))[[opened]], face)
    assert shown is not None
    assert shown["lip_gap"][0] > 10
    assert shown["jaw"][0] > 8


def test_the_tongue_is_seen_where_the_head_has_one() -> None:
    rig, face = load_rig("arkit_tongue"), load_model("default").face
    mouth = shown_mouth(rig, face)
    assert mouth is not None
    assert mouth.tongue is not None
    raised = mouth.tongue[rig.controls.index("tongueTipUp")]
    assert raised[TONGUE.index("tongue_tip_height")] > 8
    assert mouth.tongue[rig.controls.index("jawOpen"), TONGUE.index("tongue_tip_height")] < -15


def test_landmarks_show_themselves_and_drawn_mouths_nothing() -> None:
    face = load_model("default").face
    rig = load_rig("face")
    shown = show_mouth(rig, rig.rest[None], face)
    assert shown is not None
    assert shown["jaw"][0] == 0
    assert shown["lip_width"][0] == 0
    assert show_mouth(load_rig("rhubarb"), np.zeros((1, 9)), face) is None
