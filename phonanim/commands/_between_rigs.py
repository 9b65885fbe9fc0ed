"""Animations on other rigs than their own, for `phonanim convert`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from phonanim.animation.animation import Animation

Converted = tuple["Animation", tuple[str, ...]]
SHOWN = 4  # names in a note


def on_rig(animation: Animation, name: str) -> Converted:
    """The animation on a rig, and notes: its channels are the rig's already, or become them by a table.

    A rig that is not there is only a name.
    """
    from phonanim.rig import load_rig
    from phonanim.rig.read import rig_names

    if name not in rig_names() and not Path(name).is_file():
        return replace(animation, rig=name), ()
    rig = load_rig(name)
    own = sum(channel in rig.controls for channel in animation.channels)
    if 2 * own >= len(animation.channels):
        return replace(animation, rig=rig.name), ()
    return _moved(animation, name) or (replace(animation, rig=rig.name), ())


def for_formats(
    animation: Animation, outputs: Sequence[Path], has_character: bool
) -> tuple[dict[Path, Animation], tuple[str, ...]]:
    """The animation for each output, on the rig that its format needs where a table leads there; notes."""
    from phonanim.exporters import needed_rig

    found: dict[Path, Animation] = {}
    notes: list[str] = []
    known: dict[str, Converted] = {}
    for path in outputs:
        name = needed_rig(path, animation.channels, has_character)
        if name and name not in known:
            known[name] = _moved(animation, name) or (animation, ())
            notes += known[name][1]
        found[path] = known[name][0] if name else animation
    return found, tuple(notes)


def _moved(animation: Animation, name: str) -> Converted | None:
    """The animation on another rig; None where no table leads there."""
    import numpy as np

    from phonanim.rig import load_rig
    from phonanim.rig.between import are_related, convert_controls
    from phonanim.rig.read import rig_names

    if animation.rig not in rig_names():
        return None
    source, target = load_rig(animation.rig), load_rig(name)
    if not are_related(source, target) or not set(source.controls) & set(animation.channels):
        return None
    values = np.tile(source.rest.astype(np.float32), (len(animation.values), 1))
    for column, control in enumerate(source.controls):
        if control in animation.channels:
            values[:, column] = animation.channel(control)
    moved, lost = convert_controls(values, source, target)
    notes = [f"converted from the rig {source.name} to {target.name} by its table"]
    if lost:
        more = f" and {len(lost) - SHOWN} more" if len(lost) > SHOWN else ""
        notes.append(f"{target.name} has nothing for {', '.join(lost[:SHOWN])}{more}, so they are left out")
    return replace(animation, values=moved, channels=target.controls, rig=target.name), tuple(notes)
