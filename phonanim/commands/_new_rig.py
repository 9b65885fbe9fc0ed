"""Start a new rig: the eight poses to copy, and a file to fill in."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.core.files import write_text
from phonanim.errors import RigError
from phonanim.exporters.glb import write as write_glb
from phonanim.face.model import FaceModel
from phonanim.rig.head import load_head
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.rig.meshes import write_obj
from phonanim.rig.pose_pictures import draw_poses
from phonanim.rig.read import load_rig
from phonanim.rig.rig import MEAN, POSES
from phonanim.rig.write import toml_key

EXAMPLE = ("jaw", "lips_round", "lips_wide")


def write_rig_template(folder: Path, controls: tuple[str, ...], face: FaceModel) -> list[Path]:
    """Write what an artist needs to pose a character: pictures, meshes and a TOML file to fill in.

    The shipped head shows the mean and the eight poses: as a picture, as one OBJ each, and as a GLB with a
    pose per second. Returns the files. Raises RigError when the TOML file exists already, OutputError when
    the folder cannot be written.
    """
    sheet = folder / f"{folder.name}.toml"
    if sheet.exists():
        raise RigError(f"{sheet}: already exists; choose another name, or continue with `phonanim rig check`")
    folder.mkdir(parents=True, exist_ok=True)
    write_text(sheet, rig_template(folder.name, controls, face.id))
    rig, head = load_rig("arkit"), load_head()
    values = np.vstack([rig.mean, rig.poses]).astype(np.float32)
    draw_poses(folder / "poses.png", rig, head, shipped_landmarks(), face)
    write_glb(Animation(values, rig.controls, fps=1.0, rig=rig.name), folder / "poses.glb")
    shapes = dict(zip((MEAN, *POSES), head.shape(head.weights(values, rig.controls)), strict=True))
    meshes = [folder / f"{pose}.obj" for pose in shapes]
    for path, vertices in zip(meshes, shapes.values(), strict=True):
        write_obj(path, vertices, head.triangles)
    return [sheet, folder / "poses.png", folder / "poses.glb", *meshes]


def rig_template(name: str, controls: tuple[str, ...], face: str) -> str:
    """The TOML to fill in: the controls with default limits, and every pose as a comment to complete."""
    lines = [
        "# A character's rig. Write its controls below, then, for each pose in poses.png, the values with",
        f"# which the character matches it. `phonanim rig check {name}.toml` reports what is missing.",
        f'name = "{name}"',
        f'face = "{face}"',
        "",
        "[controls]  # name = [minimum, rest (lips closed), maximum]",
        *(f"{toml_key(control)} = [0.0, 0.0, 1.0]" for control in controls or EXAMPLE),
    ]
    for pose, looks in {MEAN: "the reference face at its mean", **POSES}.items():
        lines += ["", f"# [poses.{pose}]  # {looks}", f"# {toml_key((controls or EXAMPLE)[0])} = 0.0"]
    return "\n".join(lines) + "\n"
