"""Animations on other rigs than their own, for `phonanim convert`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from phonanim.animation.animation import Animation

Converted = tuple["Animation", tuple[str, ...]]


def on_rig(animation: Animation, name: str) -> Converted:
    """The animation on a rig, and notes: its channels are the rig's already, or become them by a table.

    A rig that is not there is only a name.
    """
    from phonanim.animation.other_rig import move_to_rig
    from phonanim.rig import load_rig
    from phonanim.rig.read import rig_names

    if name not in rig_names() and not Path(name).is_file():
        return replace(animation, rig=name), ()
    rig = load_rig(name)
    own = sum(channel in rig.controls for channel in animation.channels)
    if 2 * own >= len(animation.channels):
        return replace(animation, rig=rig.name), ()
    return move_to_rig(animation, name) or (replace(animation, rig=rig.name), ())


def for_formats(
    animation: Animation, outputs: Sequence[Path], has_character: bool
) -> tuple[dict[Path, Animation], tuple[str, ...]]:
    """The animation for each output, on the rig that its format needs where a table leads there; notes."""
    from phonanim.animation.other_rig import move_to_rig
    from phonanim.exporters import needed_rig

    found: dict[Path, Animation] = {}
    notes: list[str] = []
    known: dict[str, Converted] = {}
    for path in outputs:
        name = needed_rig(path, animation.channels, has_character)
        if name and name not in known:
            known[name] = move_to_rig(animation, name) or (animation, ())
            notes += known[name][1]
        found[path] = known[name][0] if name else animation
    return found, tuple(notes)
