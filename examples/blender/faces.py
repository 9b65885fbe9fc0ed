"""Takes on the shape keys of meshes: an action and an NLA strip for each mesh, markers for phones."""

import json

import bpy

from .strips import lay_strip
from .takes import Take, TakeError, match_shapes

KEPT = "phonanim"  # the custom property of actions, and of the scene for its markers


def find_faces(objects: list[bpy.types.Object]) -> list[bpy.types.Object]:
    """The meshes with shape keys among objects. Raises TakeError without one."""
    faces = [one for one in objects if one.type == "MESH" and one.data.shape_keys]
    if not faces:
        raise TakeError("select a mesh that has shape keys")
    return faces


def scene_rate(scene: bpy.types.Scene) -> float:
    """Frames per second."""
    return scene.render.fps / scene.render.fps_base


def put_take(
    take: Take, faces: list[bpy.types.Object], scene: bpy.types.Scene, names: dict[str, str], first: float
) -> tuple[int, list[str]]:
    """Lay a take on meshes, its time zero at frame `first`: the count of moved keys, channels without one.

    A strip of the same name, from an earlier take, is replaced. Raises TakeError when no shape key fits.
    """
    moved, left = 0, set(take.curves)
    for face in faces:
        shapes = [block.name for block in face.data.shape_keys.key_blocks[1:]]
        found = match_shapes(list(take.curves), shapes, names)
        left -= set(found)
        moved += len(found)
        if found:
            _put_strip(take, face.data.shape_keys, found, scene, first)
    if not moved:
        shown = ", ".join(list(take.curves)[:3])
        raise TakeError(
            f"no shape key of the selected meshes is named like {shown} ...; give a table of names"
        )
    return moved, [name for name in take.curves if name in left]


def read_back(face: bpy.types.Object, scene: bpy.types.Scene, name: str = "") -> tuple[Take, Take]:
    """The take that was laid on a mesh, and what its curves are now. Raises TakeError without one.

    Without a name, the take of the active action, else of the last strip.
    """
    action = _find_action(face.data.shape_keys, name)
    kept = json.loads(action[KEPT])
    base = Take(kept["name"], kept["document"])
    rate, curves = scene_rate(scene), dict(base.curves)
    keyed = {curve.data_path: curve for curve in _curves(action)}
    for channel, shape in kept["shapes"].items():
        curve = keyed.get(_path(shape))
        if curve is not None:
            curves[channel] = [curve.evaluate(kept["first"] + time * rate) for time in base.times]
    return base, Take(base.name, {**base.document, "curves": curves})


def _put_strip(
    take: Take, keys: bpy.types.Key, found: dict[str, str], scene: bpy.types.Scene, first: float
) -> None:
    frames = [first + time * scene_rate(scene) for time in take.times]
    curves = [(_path(shape), 0, take.curves[channel]) for channel, shape in found.items()]
    action = lay_strip(keys, take.name, frames, curves)
    kept = {"name": take.name, "document": take.document, "shapes": found, "first": first}
    action[KEPT] = json.dumps(kept)


def _path(shape: str) -> str:
    return f'key_blocks["{bpy.utils.escape_identifier(shape)}"].value'


def _curves(action: bpy.types.Action) -> list[bpy.types.FCurve]:
    bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    return [curve for bag in bags for curve in bag.fcurves]


def _find_action(keys: bpy.types.Key, name: str) -> bpy.types.Action:
    data = keys.animation_data
    strips = [strip.action for track in data.nla_tracks for strip in track.strips] if data else []
    actions = [data.action, *reversed(strips)] if data else []
    ours = [one for one in actions if one is not None and KEPT in one]
    named = [one for one in ours if not name or json.loads(one[KEPT])["name"] == name]
    if not named:
        raise TakeError("the mesh has no line of phonanim; import one, or animate an alignment")
    return named[0]
