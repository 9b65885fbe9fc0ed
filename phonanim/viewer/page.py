"""Common parts of pages that show a moving head, and the data in them."""

from __future__ import annotations

import base64
from functools import cache
from pathlib import Path

from phonanim.media.glb import Glb
from phonanim.rig.morphs import moving_morphs

PAGE = Path(__file__).parent


def character_targets(channels: tuple[str, ...], glb: Glb) -> list[tuple[int, int, int, float]]:
    """(channel, mesh, target, share) for what channels move. Raises RigError when they move nothing."""
    found: dict[tuple[int, int, int], float] = {}
    for morphs in moving_morphs(glb, channels):
        mesh = glb.tree["nodes"][morphs.node]["mesh"]
        found |= {(column, mesh, target): share for column, target, share in morphs.moved(channels)}
    return [(*place, share) for place, share in sorted(found.items())]


def base64_text(data: bytes) -> str:
    """Bytes as base64 text."""
    return base64.b64encode(data).decode("ascii")


@cache
def read_page_part(name: str) -> str:
    """Read one of the parts of the page."""
    return (PAGE / name).read_text(encoding="utf-8")
