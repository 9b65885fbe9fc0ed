"""An exporter for a robot's jaw: the angle of its servo in degrees, one line per frame."""

from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.core.files import write_text
from phonanim.errors import OutputError

SUMMARY = "Angles of a jaw servo in degrees, one line per frame"


def write(animation: Animation, path: Path, degrees: float = 30.0) -> None:
    """Write the curve of jawOpen times `degrees`. Raises OutputError when the rig has no jawOpen."""
    if "jawOpen" not in animation.channels:
        raise OutputError(f"{path}: the rig {animation.rig} has no jawOpen; use --rig arkit")
    angles = degrees * animation.channel("jawOpen")
    write_text(path, "".join(f"{angle:.1f}\n" for angle in angles))
