"""Which controls of a rig find a shape in a character and which shapes a control; the rig that fits best."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from phonanim.errors import RigError
from phonanim.media.glb import Glb, read_glb
from phonanim.rig.morphs import find_morphs
from phonanim.rig.names import plain_name
from phonanim.rig.neck import TURNS
from phonanim.rig.read import load_rig
from phonanim.rig.rig import Rig

CANDIDATES = ("metahuman", "arkit", "oculus15", "vrm")  # the first of those that find equally many shapes
LISTED = 8  # names that a message lists


def coverage_notes(path: Path, rig: str, channels: tuple[str, ...]) -> list[str]:
    """What a character leaves unmoved: controls without a shape, shapes without a control, empty shapes.

    `rig` is the name of the rig whose `channels` move the character. Raises RigError when the file cannot be
    read.
    """
    glb = read_glb(path)
    groups = find_morphs(glb)
    mouth = _mouth_of(rig, channels)
    lacking = [name for name in mouth if name not in found_controls(glb, mouth)]
    shapes = list(dict.fromkeys(name for one in groups for name in one.names if name))
    present = frozenset().union(*(one.present or frozenset(one.names) for one in groups))
    empty = [name for name in shapes if name not in present]
    used = {one.names[target] for one in groups for _, target, _ in one.moved(channels)}
    idle = [name for name in shapes if name not in used and name in present]
    notes = []
    if lacking:
        have = "has" if len(lacking) == 1 else "have"
        notes.append(f"{len(lacking)} of {len(mouth)} mouth controls {have} no shape: {_listed(lacking)}")
    if empty:
        moves = "moves nothing and is" if len(empty) == 1 else "move nothing and are"
        notes.append(f"{len(empty)} of {len(shapes)} shapes {moves} left out: {_listed(empty)}")
    if idle:
        have = "has" if len(idle) == 1 else "have"
        notes.append(f"{len(idle)} of {len(shapes)} shapes {have} no control: {_listed(idle)}")
    return [f"{path}: {note}" for note in notes]


def choose_rig(path: Path) -> tuple[str, str]:
    """The shipped rig of whose mouth controls a character has the largest share, and that share as text.

    Raises RigError when the file cannot be read or has a shape for none of them.
    """
    glb = read_glb(path)
    shares = {}
    for name in CANDIDATES:
        mouth = mouth_controls(load_rig(name))
        shares[name] = len(found_controls(glb, mouth)) / len(mouth), f"of {len(mouth)} mouth controls"
    best = max(CANDIDATES, key=lambda name: shares[name][0])
    share, of = shares[best]
    if not share:
        raise RigError(
            f"{path}: no name of its shapes is known; name them in a table, shape,control, and give it as "
            f"--names, or make a rig: phonanim rig fit {path.name}"
        )
    return best, f"{share:.0%} {of}"


def found_controls(glb: Glb, controls: tuple[str, ...]) -> set[str]:
    """The controls that move some shape of a character. Raises RigError."""
    moved = [one.moved(controls) for one in find_morphs(glb)]
    return {controls[column] for pairs in moved for column, _, _ in pairs}


def mouth_controls(rig: Rig) -> tuple[str, ...]:
    """The controls by which a rig's mouth speaks."""
    if rig.mouth is not None:
        return tuple(name for group in rig.mouth.names for name in group)
    if rig.through is not None:
        other = rig.through.rig
        rows = [other.controls.index(name) for name in mouth_controls(other)]
        moved = np.any(rig.through.table[rows] != 0, axis=0)
        return tuple(name for name, moves in zip(rig.controls, moved, strict=True) if moves)
    return rig.speech or rig.controls


def _mouth_of(rig: str, channels: tuple[str, ...]) -> tuple[str, ...]:
    """The mouth's channels: those of a rig that is known by name, else all but the turns of the head."""
    try:
        mouth = set(map(plain_name, mouth_controls(load_rig(rig))))
    except RigError:
        mouth = set()
    found = tuple(name for name in channels if plain_name(name) in mouth)
    return found or tuple(name for name in channels if name not in TURNS)


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return ", ".join(names[:LISTED]) + more
