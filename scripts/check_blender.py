"""Check that Blender plays what was written: shape-key values at every frame against the take itself.

Blender's package pins NumPy below 2, so it has an environment of its own (300 MB):

    python3.11 -m venv blender && blender/bin/pip install bpy==5.0.1
    phonanim animate line.TextGrid -o line.npz -o line.glb -o line.usda
    blender/bin/python scripts/check_blender.py line.npz line.glb line.usda

Ends with status 1 when a value differs by more than a millionth.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np

TOLERANCE = 1e-6
IMPORTERS = {".glb": "gltf", ".usda": "usd", ".usdc": "usd"}


def main() -> None:
    """Compare each file with the take, an NPZ that phonanim wrote."""
    take, *files = map(Path, sys.argv[1:])
    with np.load(take) as archive:
        values, channels = archive["values"], archive["channels"].tolist()
        fps, start = float(archive["fps"]), float(archive["start"])
    worst = 0.0
    for path in files:
        shown = play(path, channels, fps, start, len(values))
        error = float(np.abs(shown - values).max())
        print(f"{path}: {len(values)} frames, {len(channels)} channels, largest difference {error:.2e}")
        worst = max(worst, error)
    sys.exit(worst > TOLERANCE)


def play(path: Path, channels: list[str], fps: float, start: float, count: int) -> np.ndarray:
    """The value of every channel's shape key at every frame, (frames, channels)."""
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
        for column, name in enumerate(channels):
            found = [key.key_blocks[name].value for key in keys if name in key.key_blocks]
            if not found or max(found) != min(found):
                sys.exit(f"{path}: shape keys called {name} have the values {found}")
            shown[frame, column] = found[0]
    return shown


if __name__ == "__main__":
    main()
