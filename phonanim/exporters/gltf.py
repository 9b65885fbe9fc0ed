"""glTF as text, in one file: a head, or a character of the user's own, with the animation added to it."""

from __future__ import annotations

import json
from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.core.files import write_text
from phonanim.exporters._gltf import add_animation
from phonanim.exporters._gltf import read as read
from phonanim.exporters._head import RIG as RIG
from phonanim.exporters._head import fits as fits
from phonanim.media.glb import kept_glb, parse_glb
from phonanim.media.gltf_text import data_uri
from phonanim.rig.head import SHIPPED

SUMMARY = "glTF as text, its data within: the shipped head, or your own character, speaking"


def write(animation: Animation, path: Path, character: Path = SHIPPED, keys: float | None = None) -> None:
    """Write what `glb.write` writes, as JSON whose buffer is a data URI. Raises RigError, OutputError."""
    packed = add_animation(kept_glb(character), animation, path.name.split(".")[0], keys)
    glb = parse_glb(packed, str(path))
    buffer = {**glb.tree["buffers"][0], "uri": data_uri(glb.binary)}
    tree = {**glb.tree, "buffers": [buffer, *glb.tree["buffers"][1:]]}
    write_text(path, json.dumps(tree, separators=(",", ":"), ensure_ascii=False, allow_nan=False) + "\n")
