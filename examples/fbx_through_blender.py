"""A speaking character from GLB to FBX and back, by Blender.

    blender --background --python examples/fbx_through_blender.py -- line.glb line.fbx
    blender --background --python examples/fbx_through_blender.py -- edited.fbx edited.glb

Python with the package `bpy` (pip install bpy) runs it, too, without `blender ... --`. Frames have the rate
of `--fps 30`, 60 by default.
"""

from __future__ import annotations

import sys

import bpy


def convert(source: str, target: str, fps: float) -> None:
    """Read one file into an empty scene and write the other."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = round(fps), round(fps) / fps
    if source.lower().endswith(".fbx"):
        bpy.ops.import_scene.fbx(filepath=source)
        scene.render.fps, scene.render.fps_base = round(fps), round(fps) / fps
    else:
        bpy.ops.import_scene.gltf(filepath=source)
    if not bpy.data.actions:
        raise SystemExit(f"{source}: has no animation")
    scene.frame_start = int(min(action.frame_range[0] for action in bpy.data.actions))
    scene.frame_end = round(max(action.frame_range[1] for action in bpy.data.actions))
    for thing in [one for one in bpy.data.objects if one.type == "MESH" and not one.data.shape_keys]:
        if thing.name.startswith("Icosphere"):  # the shape that Blender draws bones with
            bpy.data.objects.remove(thing)
    if target.lower().endswith(".fbx"):
        # The scene as it plays: strips and single actions would be written without their shape keys.
        bpy.ops.export_scene.fbx(
            filepath=target,
            bake_anim=True,
            bake_anim_use_nla_strips=False,
            bake_anim_use_all_actions=False,
            bake_anim_simplify_factor=0.0,
            add_leaf_bones=False,
        )
    else:
        bpy.ops.export_scene.gltf(
            filepath=target, export_format="GLB", export_animation_mode="ACTIVE_ACTIONS"
        )


def main() -> None:
    """Take the file names after -- (in Blender) or all of them (in Python)."""
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    fps = 60.0
    if "--fps" in given:
        place = given.index("--fps")
        fps = float(given[place + 1])
        del given[place : place + 2]
    if len(given) != 2:
        raise SystemExit("give the file to read and the file to write")
    convert(given[0], given[1], fps)


if __name__ == "__main__":
    main()
