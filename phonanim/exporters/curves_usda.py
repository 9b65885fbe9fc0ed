"""USD as text, the curves alone: a SkelAnimation without skeleton and meshes, to bind to a head elsewhere."""

from __future__ import annotations

from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.core.files import write_pieces
from phonanim.exporters._usd import read as read
from phonanim.exporters._usd_stage import curves_text

SUMMARY = "USD as text, curves alone: a UsdSkel animation without a mesh, for any rig"
NO_TURNS = "turns no head, because the format has no place for it"


def write(animation: Animation, path: Path) -> None:
    """Write a SkelAnimation with a weight for each channel; time codes are frames from time zero.

    Turns of the head are not in the file. Raises OutputError when the destination cannot be written.
    """
    write_pieces(path, curves_text(animation))
