"""Common parts of pages that show a moving head, and the data in them."""

from __future__ import annotations

import base64
from functools import cache
from pathlib import Path

from phonanim.errors import RigError
from phonanim.media.glb import Glb, read_glb
from phonanim.media.gltf import external_files
from phonanim.rig.morphs import moving_morphs

PAGE = Path(__file__).parent


def character_targets(channels: tuple[str, ...], glb: Glb) -> list[tuple[int, int, int, float]]:
    """(channel, mesh, target, share) for what channels move. Raises RigError when they move nothing."""
    found: dict[tuple[int, int, int], float] = {}
    for morphs in moving_morphs(glb, channels):
        mesh = glb.tree["nodes"][morphs.node]["mesh"]
        found |= {(column, mesh, target): share for column, target, share in morphs.moved(channels)}
    return [(*place, share) for place, share in sorted(found.items())]


def read_character(path: Path) -> Glb:
    """A character that a page can show. Raises RigError where it is compressed or needs other files."""
    glb = read_glb(path)
    glb.refuse_compressed()  # the page cannot decode compressed meshes
    if outside := external_files(glb.tree):
        raise RigError(
            f"{path}: its {outside[0]!r:.60} is outside the file, and the page loads no other files; "
            "pack it with: npx @gltf-transform/cli copy IN.glb OUT.glb"
        )
    return glb


def base64_text(data: bytes) -> str:
    """Bytes as base64 text."""
    return base64.b64encode(data).decode("ascii")


@cache
def read_page_part(name: str) -> str:
    """Read one of the parts of the page."""
    return (PAGE / name).read_text(encoding="utf-8")
