"""Godot Animation resource: a track for each blend shape of a MeshInstance3D (Godot 4) or MeshInstance (3).

Value tracks of the property `blend_shapes/NAME` and the older format number 2 are what both versions load.
The paths of a character's meshes are those of the scene that Godot 4 imports from its file.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.core.files import write_text
from phonanim.errors import OutputError
from phonanim.exporters._godot import read_scene
from phonanim.exporters._shapes import KEYS, HeadTurn, ShapeCurve, curve_keys, head_turn, shape_curves

SUMMARY = "Godot 3 and 4 Animation resource for the blend shapes of a mesh"
HEADER = """[gd_resource type="Animation" format=2]

[resource]
resource_name = {name}
length = {length}
step = {step}
"""
TRACK = """tracks/{number}/type = "value"
tracks/{number}/path = NodePath({path})
tracks/{number}/interp = 1
tracks/{number}/loop_wrap = false
tracks/{number}/imported = false
tracks/{number}/enabled = true
tracks/{number}/keys = {{
"times": PoolRealArray( {times} ),
"transitions": PoolRealArray( {ones} ),
"update": 0,
"values": [ {values} ]
}}
"""
TURN = """tracks/{number}/type = "rotation_3d"
tracks/{number}/path = NodePath({path})
tracks/{number}/interp = 1
tracks/{number}/loop_wrap = false
tracks/{number}/imported = false
tracks/{number}/enabled = true
tracks/{number}/keys = PoolRealArray( {keys} )
"""
NO_TURNS_ALONE = "turns no head, because no --character shows its bone"


def write(
    animation: Animation,
    path: Path,
    node: str | None = None,
    character: Path | None = None,
    keys: float = KEYS,
) -> None:
    """Write an animation; `node` is the path of the mesh from the AnimationPlayer's root node.

    With a `character`, a GLB or VRM, the tracks move its meshes by the names of their shapes, where Godot 4
    puts them. Frames are left out if linear interpolation is within the error `keys`. The last track
    turns the bone of the character's head in Godot 4; Godot 3 leaves it out.
    Raises RigError when the character cannot be used, OutputError when a name cannot stand in a path or the
    destination cannot be written.
    """
    found = shape_curves(animation, node, character, lambda glb, number: read_scene(glb).mesh(number))
    if character is not None:  # the importer renames such shapes
        found = [replace(one, shape=one.shape.replace(":", "_")) for one in found]
    for one in found:
        if ":" in one.node or ":" in one.shape:
            raise OutputError(f"{path}: Godot allows no colon in a path: {one.node}, {one.shape}; rename it")
    header = HEADER.format(
        name=json.dumps(path.name.split(".")[0], ensure_ascii=False),
        length=f"{(len(animation.values) - 1) / animation.fps + max(0.0, animation.start):.9g}",
        step=f"{1 / animation.fps:.9g}",
    )
    tracks = [_track(animation, one, n, keys) for n, one in enumerate(found)]
    if turn := head_turn(animation, character):
        tracks.append(_turn_track(animation, turn, len(tracks), keys))
    write_text(path, header + "".join(tracks))


def _turn_track(animation: Animation, turn: HeadTurn, number: int, keys: float) -> str:
    """The rotation of a bone in the skeleton that Godot's importer makes."""
    times, rotations = turn.keys(animation, keys)
    rows = np.column_stack([times, np.ones(len(times)), rotations + 0.0])
    return TURN.format(
        number=number,
        path=json.dumps(read_scene(turn.glb).bone(turn.node), ensure_ascii=False),
        keys=", ".join(f"{value:.7g}" for value in rows.ravel().tolist()),
    )


def _track(animation: Animation, one: ShapeCurve, number: int, keys: float) -> str:
    times, values = curve_keys(animation, one.curve, keys)
    return TRACK.format(
        number=number,
        path=json.dumps(f"{one.node}:blend_shapes/{one.shape}", ensure_ascii=False),
        times=", ".join(f"{time:.9g}" for time in times.tolist()),
        ones=", ".join("1" for _ in times),
        values=", ".join(_real(value) for value in values.tolist()),
    )


def _real(value: float) -> str:
    """A number that is read as a float, not as an integer."""
    text = f"{value:.7g}"
    return text if set(text) & set(".e") else f"{text}.0"
