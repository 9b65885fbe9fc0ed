"""An animation on another rig than its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.rig import load_rig
from phonanim.rig.between import are_related, convert_controls
from phonanim.rig.read import rig_names

SHOWN = 4  # names in a note


def move_to_rig(animation: Animation, name: str) -> tuple[Animation, tuple[str, ...]] | None:
    """The animation on a rig, by the tables of rigs, and notes; None where no table leads there."""
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
