"""VRM: your own character speaking, through its expressions or its morph targets."""

from __future__ import annotations

from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.errors import OutputError
from phonanim.exporters._gltf import add_to_character
from phonanim.exporters._gltf import read as read

SUMMARY = "VRM 0.x or 1.0: your own character, speaking"
NOTE = "a glTF viewer plays it; programs that know VRM move its expressions by a .vrma file"


def write(animation: Animation, path: Path, character: Path | None = None, keys: float | None = None) -> None:
    """Add the animation to a VRM file, as `glb.write` does; there is no default VRM.

    Raises OutputError when no character is given, and what `glb.write` raises.
    """
    if character is None:
        raise OutputError(f"{path}: a .vrm needs your own character; name it, or write a .glb")
    add_to_character(animation, path, character, keys)
