"""Curves of any rig as a plain table, and what is no such table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from phonanim.animation.animation import Animation
from phonanim.errors import OutputError
from phonanim.exporters import load, save


def test_a_table_of_any_rig(tmp_path: Path) -> None:
    values = np.array([[0.25, -3.5], [1 / 3, 200.0], [0, 0]], np.float32)
    save(Animation(values, ("mouth_oh", "jaw, open"), 30.0, "mine", start=0.5), tmp_path / "a.curves.csv")
    lines = (tmp_path / "a.curves.csv").read_text("utf-8").splitlines()
    assert lines[0] == 'seconds,mouth_oh,"jaw, open"'
    assert lines[1] == "0.5,0.25,-3.5"
    again = load(tmp_path / "a.curves.csv")
    assert again.channels == ("mouth_oh", "jaw, open")
    assert (again.fps, again.start) == (30.0, 0.5)
    assert np.array_equal(again.values, values)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "its header must begin with seconds"),
        ("time,a\n0,1\n", "its header must begin with seconds"),
        ("seconds,a\n0,1\n", "fewer than two frames"),
        ("seconds,a\n0,1\n1,x\n", "row 3: could not convert"),
        ("seconds,a\n0,1\n1\n", "row 3: has 1 cells, and the header 2"),
        ("seconds,a\n0,1\n1,1\n2,1\n4,1\n", "row 5: its frames are not evenly spaced"),
        ("seconds,a\n1,1\n0,1\n", "run backwards"),
        ("seconds,a,a\n0,1,1\n1,1,1\n", "two of its channels are called 'a'"),
    ],
)
def test_what_is_no_table(text: str, why: str, tmp_path: Path) -> None:
    (tmp_path / "a.curves.csv").write_text(text, "utf-8")
    with pytest.raises(OutputError, match=why):
        load(tmp_path / "a.curves.csv")
