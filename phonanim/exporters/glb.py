"""Binary glTF: a head, or a character of the user's own, with the animation added to it."""

from __future__ import annotations

from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.exporters._gltf import add_to_character
from phonanim.exporters._gltf import read as read
from phonanim.exporters._head import RIG as RIG
from phonanim.exporters._head import fits as fits
from phonanim.rig.head import SHIPPED

SUMMARY = "glTF binary: the shipped head, or your own character, speaking"


def write(animation: Animation, path: Path, character: Path = SHIPPED, keys: float | None = None) -> None:
    """Add the animation to a GLB or VRM file; everything else in it is unchanged, byte for byte.

    `character` has morph targets or VRM expressions with the names of the channels. With `keys`, frames are
    left out if linear interpolation is within that error. Raises RigError when the character cannot be used,
    OutputError when the destination cannot be written.
    """
    add_to_character(animation, path, character, keys)
