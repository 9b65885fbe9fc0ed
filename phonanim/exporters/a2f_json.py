"""Audio2Face JSON: weights of blend shapes by frame, for the programs that import NVIDIA's exports."""

from __future__ import annotations

import json
from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.core.decode import DAMAGE, read_json
from phonanim.core.files import write_text
from phonanim.errors import OutputError
from phonanim.exporters._a2f import from_audio2face, to_audio2face

SUMMARY = "Audio2Face JSON: blend shape weights by frame, as NVIDIA's programs export them"
NO_TURNS = "turns no head, because the format has no place for it"


def write(animation: Animation, path: Path) -> None:
    """Write facsNames and weightMat at the animation's rate. Raises OutputError."""
    write_text(path, json.dumps(to_audio2face(animation), ensure_ascii=False) + "\n")


def read(path: Path) -> Animation:
    """Read an export of Audio2Face, 60 frames per second unless it says so. Raises OutputError."""
    try:
        return from_audio2face(read_json(path), path)
    except (OSError, *DAMAGE) as error:
        reason = f"it lacks {error}" if isinstance(error, KeyError) else " ".join(str(error).split())
        raise OutputError(f"{path}: is not an export of Audio2Face: {reason}") from error
