"""Universal Scene Description in binary form; the same stage as `.usda`, smaller."""

from __future__ import annotations

from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.exporters._head import RIG as RIG
from phonanim.exporters._head import fits as fits
from phonanim.exporters._usd import read as read
from phonanim.exporters._usd import write_binary
from phonanim.exporters._usd_stage import stage_text
from phonanim.rig.head import SHIPPED

SUMMARY = "USD in binary form (needs the extra usd)"


def write(animation: Animation, path: Path, character: Path = SHIPPED) -> None:
    """Write a stage as `usda.write` does. Raises MissingExtraError without the extra `usd`."""
    write_binary("".join(stage_text(animation, character)), path)
