"""Common parts of pages that show a moving head, and the data in them."""

from __future__ import annotations

import base64
from functools import cache
from pathlib import Path

from phonanim.media.glb import Glb
from phonanim.rig.morphs import moving_morphs

PAGE = Path(__file__).parent


def character_targets(channels: tuple[str, ...], glb: Glb) -> dict[str, str]:
    """The morph target of a character that each channel moves. Raises RigError when no channel has one."""
    found: dict[str, str] = {}
    for morphs in moving_morphs(glb, channels):
        found |= {channels[column]: morphs.names[target] for column, target, _ in morphs.moved(channels)}
    return found


def base64_text(data: bytes) -> str:
    """Bytes as base64 text."""
    return base64.b64encode(data).decode("ascii")


@cache
def read_page_part(name: str) -> str:
    """Read one of the parts of the page."""
    return (PAGE / name).read_text(encoding="utf-8")
