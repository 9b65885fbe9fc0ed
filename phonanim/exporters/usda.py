"""Universal Scene Description as text: the head with blend shapes, and a UsdSkel animation of them."""

from __future__ import annotations

from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.core.files import write_pieces
from phonanim.exporters._head import RIG as RIG
from phonanim.exporters._head import fits as fits
from phonanim.exporters._usd import read as read
from phonanim.exporters._usd_stage import stage_text
from phonanim.rig.head import SHIPPED

SUMMARY = "USD as text: the head with UsdSkel blend shapes and their animation"


def write(animation: Animation, path: Path, character: Path = SHIPPED) -> None:
    """Write a stage in metres with y up; time codes are frames from time zero.

    `character` is a GLB or VRM with named morph targets. Raises RigError when it cannot be used or has
    none of the channels, OutputError when the destination cannot be written.
    """
    write_pieces(path, stage_text(animation, character))
