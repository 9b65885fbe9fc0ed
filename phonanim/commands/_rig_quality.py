"""How a rig's own head follows the shipped head, for `phonanim rig check` and `phonanim rig fit`."""

from __future__ import annotations

from pathlib import Path

from phonanim.errors import RigError
from phonanim.pipeline import load_model
from phonanim.rig.character import load_character
from phonanim.rig.fit_quality import FitQuality, fit_quality
from phonanim.rig.landmarks import read_landmarks
from phonanim.rig.own_head import own_head
from phonanim.rig.phone_pictures import draw_phones
from phonanim.rig.pose_pictures import draw_poses
from phonanim.rig.read import load_rig
from phonanim.rig.rig import Rig


def check_quality(rig: Rig, model: str, phones: Path | None) -> FitQuality | None:
    """How a rig follows on its own head; none without a head or a table of its mouth.

    `phones` is a picture to draw. Raises RigError when it cannot be drawn.
    """
    if rig.head is None or rig.landmarks is None or rig.mouth is None:
        if phones is not None:
            raise RigError(f"rig {rig.name} names no head and no mouth to draw; phonanim rig fit makes both")
        return None
    found = own_head(rig)
    if found is None:
        return None
    head, landmarks = found
    face = load_model(model).face
    if phones is not None:
        draw_phones(phones, rig, head, landmarks, face)
    return fit_quality(rig, head, landmarks, face)


def quality_lines(quality: FitQuality) -> list[str]:
    """A line per measure, and one for each that falls short."""
    lines = [f"  {name}: {followed}" for name, followed in quality.measures.items()]
    return [*lines, *(f"  {line}" for line in quality.short)]


def draw(path: Path, sheet: Path, model: str) -> None:
    """Draw a rig's poses on its own head. Raises RigError when its file names no head."""
    rig = load_rig(str(path))
    if rig.head is None or rig.landmarks is None or not rig.posed:
        raise RigError(
            f"{path}: names no head and landmarks to draw, or has no poses; phonanim rig fit makes both"
        )
    face = load_model(model).face
    draw_poses(sheet, rig, load_character(rig.head), read_landmarks(rig.landmarks), face)
