"""Front rounded vowels pucker the lips, in the language that has them."""

from __future__ import annotations

from pathlib import Path

import pytest

import phonanim
from phonanim.speech.intervals import Interval
from phonanim.speech.textgrid import write_textgrid


@pytest.mark.parametrize(
    ("language", "labels"), [("french", "s a l y"), ("german", "d y n"), ("turkish", "ɟ y n")]
)
def test_a_short_y_puckers_the_lips(language: str, labels: str, tmp_path: Path) -> None:
    phones = [Interval(label, 0.3 + 0.12 * n, 0.42 + 0.12 * n) for n, label in enumerate(labels.split())]
    write_textgrid(tmp_path / "x.TextGrid", {"phones": phones}, phones[-1].end + 0.3)
    animation = phonanim.animate(tmp_path / "x.TextGrid", language=language, rig="arkit")
    pucker = animation.values[:, animation.channels.index("mouthPucker")]
    (y,) = (phone for phone in animation.phones if phone.label == "y")
    assert pucker[round(y.start * animation.fps) : round(y.end * animation.fps) + 1].max() >= 0.25
