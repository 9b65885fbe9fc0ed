"""The head of a file, for formats that draw it or take it apart."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from phonanim.errors import RigError
from phonanim.rig.head import SHIPPED, Head, load_dressed_head, load_head
from phonanim.rig.morphs import plain_name

RIG = "arkit"
"""The rig of the shipped head."""


def fits(channels: Sequence[str]) -> bool:
    """Whether the shipped head has a shape for any of these channels."""
    return not set(map(plain_name, load_head().targets)).isdisjoint(map(plain_name, channels))


def load_drawable_head(character: Path = SHIPPED) -> Head:
    """The package's dressed head, or the meshes with morph targets of a GLB or VRM file, in world axes.

    Raises RigError when the file cannot be read, is compressed, or has other units or another up axis than
    glTF's, which another program would not notice.
    """
    if character == SHIPPED:
        return load_dressed_head()
    from phonanim.rig.character import load_character
    from phonanim.rig.orientation import orientation_warnings

    head = load_character(character)
    if odd := orientation_warnings(head):
        raise RigError(f"{character}: {odd[0]}")
    return head
