"""Options as text, parsed to values."""

from __future__ import annotations

import pytest

from phonanim.animation.option_parsing import parse_closures, parse_gains, parse_overlay
from phonanim.animation.overlay import is_pose
from phonanim.errors import OptionError
from phonanim.options import Closure, Overlay


def test_gains_by_control() -> None:
    assert parse_gains([" jawOpen=1.2", "mouthClose=0"]) == {"jawOpen": 1.2, "mouthClose": 0.0}
    with pytest.raises(OptionError, match="'jawOpen' is not CONTROL=NUMBER"):
        parse_gains(["jawOpen"])
    with pytest.raises(OptionError, match="jawOpen has two gains"):
        parse_gains(["jawOpen=1", "jawOpen=2"])


@pytest.mark.parametrize(
    ("text", "overlay"),
    [
        ("smile", Overlay("smile")),
        ("smile=0.5", Overlay("smile", 0.5)),
        ("a/b.json@1.2-3", Overlay("a/b.json", 1.0, (1.2, 3.0))),
        ("smile=0.5@1-2", Overlay("smile", 0.5, (1.0, 2.0))),
    ],
)
def test_an_overlay_as_text(text: str, overlay: Overlay) -> None:
    assert parse_overlay(text) == overlay


def test_a_span_that_ends_before_it_starts() -> None:
    with pytest.raises(OptionError, match=r"smile@3-1: its span must end after it starts"):
        parse_overlay("smile@3-1")


def test_poses_are_known_by_name() -> None:
    assert is_pose("smile")
    assert not is_pose("smile.json")


def test_closures_are_spans_that_are_held_or_released():
    found = parse_closures(["hold@1.2-1.35", " release@2-2.1"])
    assert found == (Closure("hold", 1.2, 1.35), Closure("release", 2.0, 2.1))


@pytest.mark.parametrize("text", ["hold", "bite@1-2", "hold=1@1-2", "hold@2-1", "@1-2", "hold@1.2.3-4"])
def test_other_closures_are_refused(text):
    with pytest.raises(OptionError, match="@1"):
        parse_closures([text])
