"""Check that Blender plays what was written: shape keys and turns of the head against the take itself.

Blender's package pins NumPy below 2, so it has an environment of its own (300 MB):

    python3.11 -m venv blender && blender/bin/pip install bpy==5.0.1
    phonanim animate line.TextGrid -o line.npz -o line.glb -o line.usda
    blender/bin/python scripts/check_blender.py line.npz line.glb line.usda

Ends with status 1 when a shape key differs by more than a millionth, or a turn of the head by more than a
thousandth of a degree.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np

TOLERANCE, TURN_TOLERANCE = 1e-6, 1e-3
TURNS = ["headPitch", "headYaw", "headRoll"]
IMPORTERS = {".glb": "gltf", ".usda": "usd", ".usdc": "usd"}


def main() -> None:
    """Compare each file with the take, an NPZ that phonanim wrote."""
    take, *files = map(Path, sys.argv[1:])
    with np.load(take) as archive:
        values, channels = archive["values"], archive["channels"].tolist()
        fps, start = float(archive["fps"]), float(archive["start"])
    turned = np.isin(channels, TURNS)
    worst = [0.0, 0.0]
    for path in files:
        apart = np.abs(play(path, channels, fps, start, len(values)) - values)
        errors = [float(apart[:, ~turned].max()), float(apart[:, turned].max(initial=0.0))]
        told = f"largest difference {errors[0]:.2e}, of the head {errors[1]:.2e} degrees"
        print(f"{path}: {len(values)} frames, {len(channels)} channels, {told}")
        worst = np.maximum(worst, errors).tolist()
    sys.exit(worst[0] > TOLERANCE or worst[1] > TURN_TOLERANCE)


def play(path: Path, channels: list[str], fps: float, start: float, count: int) -> np.ndarray:
    """The value of every channel's shape key at every frame, and degrees of the head, (frames, channels)."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = round(fps)  # with a base of 1: the glTF importer multiplies by it, and should divide
    if IMPORTERS[path.suffix] == "gltf":
        bpy.ops.import_scene.gltf(filepath=str(path))
        rate = float(scene.render.fps)
    else:
        bpy.ops.wm.usd_import(filepath=str(path), set_frame_range=True)
        rate = fps  # time codes become frames as they are
    keys = list(bpy.data.shape_keys)
    shown = np.zeros((count, len(channels)))
    for frame in range(count):
        place = (start + frame / fps) * rate
        scene.frame_set(int(place // 1), subframe=place % 1)
        turns = dict(zip(TURNS, head_turns(), strict=True))
        for column, name in enumerate(channels):
            if name in turns:
                shown[frame, column] = turns[name]
                continue
            found = [key.key_blocks[name].value for key in keys if name in key.key_blocks]
            if not found or max(found) != min(found):
                sys.exit(f"{path}: shape keys called {name} have the values {found}")
            shown[frame, column] = found[0]
    return shown


def head_turns() -> list[float]:
    """Degrees of the bone called head, in glTF's axes: about x, y and z, where y is up."""
    bones = [(one, bone) for one in bpy.data.objects if one.pose for bone in one.pose.bones]
    frame, bone = next((one, bone) for one, bone in bones if bone.name.lower().endswith("head"))
    world = np.array(frame.matrix_world.to_3x3()) / np.array(frame.matrix_world.to_scale())
    rest = np.array(bone.bone.matrix_local.to_3x3())
    moved = world @ np.array(bone.matrix.to_3x3()) @ rest.T @ world.T
    axes = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # Blender's z is up
    turn = axes @ moved @ axes.T
    pitch, yaw = -np.arcsin(turn[1, 2]), np.arctan2(turn[0, 2], turn[2, 2])
    return np.degrees([pitch, yaw, np.arctan2(turn[1, 0], turn[1, 1])]).tolist()


if __name__ == "__main__":
    main()
