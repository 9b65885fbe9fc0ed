"""A long line is moved some frames at a time, with the same bytes; a line without end is refused before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from phonanim import pipeline
from phonanim.animation import motion
from phonanim.errors import OptionError

LINE = Path(__file__).resolve().parents[2] / "examples" / "line.TextGrid"


@pytest.mark.parametrize("rig", ["arkit_tongue", "oculus15"])
def test_frames_do_not_depend_on_the_blocks(monkeypatch, rig):
    whole = pipeline.animate(LINE, rig=rig, fps=60)
    for module in (motion, pipeline):
        monkeypatch.setattr(module, "BLOCK", 50)
    parts = pipeline.animate(LINE, rig=rig, fps=60)
    np.testing.assert_array_equal(parts.values, whole.values)
    np.testing.assert_array_equal(parts.articulation, whole.articulation)


def test_no_frames_give_no_motion():
    track = pipeline.animate_detailed(LINE).track
    model, rig = pipeline.load_model("default"), pipeline.load_cached_rig("arkit")
    found = motion.predict_controls(track, model, rig, pipeline.DEFAULTS, 0)
    assert found.values.shape == (0, len(rig.controls))
    assert found.modes.shape == (0, len(model.face.std))


def test_a_line_of_too_many_frames_is_refused():
    with pytest.raises(
        OptionError, match=r"line\.TextGrid: has 272 frames at 60 fps, over 200; .* 272 \(most"
    ):
        pipeline.animate(LINE, fps=60, most_frames=200)
    allowed = pipeline.animate(LINE, fps=60, most_frames=272)
    assert "most_frames" not in allowed.provenance["options"]


@pytest.mark.parametrize(("fps", "apart"), [(24, 1), (60, 1), (120, 1), (144, 2), (239.76, 4), (1000, 16)])
def test_how_often_a_model_is_asked(fps, apart):
    assert motion.frames_apart(fps) == apart


def test_rows_between_go_through_those_that_are_known():
    rows = np.random.default_rng(0).normal(size=(12, 3)).astype(np.float32)
    found = motion.rows_between(rows, 4, 0, 45)
    np.testing.assert_array_equal(found[::4], rows)
    np.testing.assert_array_equal(motion.rows_between(rows, 4, 7, 30), found[7:30])
    bowl = (np.arange(12, dtype=np.float32)[:, None] - 4) ** 2
    np.testing.assert_allclose(
        motion.rows_between(bowl, 5, 5, 50)[:, 0], (np.arange(5, 50) / 5 - 4) ** 2, atol=1e-5
    )


def test_high_rates_show_the_same_motion_as_if_each_frame_were_asked_for(monkeypatch):
    seldom, usual = (
        pipeline.animate_detailed(LINE, pipeline.make_options(None, {"fps": fps})) for fps in (240.0, 60.0)
    )
    np.testing.assert_allclose(seldom.modes[::4], usual.modes, atol=1e-6)
    monkeypatch.setattr(pipeline, "frames_apart", lambda fps: 1)
    always = pipeline.animate_detailed(LINE, pipeline.make_options(None, {"fps": 240.0}))
    assert 0 < np.abs(seldom.animation.values - always.animation.values).max() < 0.03
    assert np.abs(seldom.animation.values - always.animation.values).mean() < 1e-4
