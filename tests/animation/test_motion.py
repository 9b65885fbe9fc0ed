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
