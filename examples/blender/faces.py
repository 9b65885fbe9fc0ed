"""Takes on the shape keys of meshes: an action and an NLA strip for each mesh, markers for phones."""

import json

import bpy

from .names import Table, match_shapes
from .strips import lay_strip
from .takes import Take, TakeError

CHANGED = 1e-4  # of full weight
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
    take: Take, faces: list[bpy.types.Object], scene: bpy.types.Scene, names: Table, first: float
) -> tuple[int, list[str]]:
    """Lay a take on meshes, its time zero at frame `first`: the count of moved keys, channels without one.

    A strip of the same name, from an earlier take, is replaced. Raises TakeError when no shape key fits.
    """
    moved, left = 0, set(take.curves)
    for face in faces:
        shapes = [block.name for block in face.data.shape_keys.key_blocks[1:]]
        found = match_shapes(list(take.curves), shapes, names)
        left -= {channel for shares in found.values() for channel in shares}
        moved += len(found)
        if found:
            _put_strip(take, face.data.shape_keys, found, scene, first)
    if not moved:
        shown = ", ".join(list(take.curves)[:3])
        raise TakeError(
            f"no shape key of the selected meshes is named like {shown} ...; give a table of names"
        )
    return moved, [name for name in take.curves if name in left]


def read_back(face: bpy.types.Object, scene: bpy.types.Scene, name: str = "") -> tuple[Take, Take, list[str]]:
    """The take that was laid on a mesh, what its curves are now, and changed shapes that are not read back.

    A shape that several channels move cannot be told apart. Without a name, the take of the active action,
    else of the last strip. Raises TakeError without one.
    """
    action = _find_action(face.data.shape_keys, name)
    kept = json.loads(action[KEPT])
    base = Take(kept["name"], kept["document"])
    rate, curves, lost = scene_rate(scene), dict(base.curves), []
    keyed = {curve.data_path: curve for curve in _curves(action)}
    shapes = kept["shapes"]
    alone = [channel for shares in shapes.values() for channel in shares]
    for shape, shares in shapes.items():
        curve = keyed.get(_path(shape))
        if curve is None:
            continue
        now = [curve.evaluate(kept["first"] + time * rate) for time in base.times]
        (channel, share), *others = shares.items()
        if not others and share > 0 and alone.count(channel) == 1:
            curves[channel] = [value / share for value in now]
        elif any(abs(a - b) > CHANGED for a, b in zip(now, _values(base, shares), strict=True)):
            lost.append(shape)
    return base, Take(base.name, {**base.document, "curves": curves}), lost


def _values(take: Take, shares: dict[str, float]) -> list[float]:
    """What channels give a shape, at each frame."""
    columns = [[share * value for value in take.curves[channel]] for channel, share in shares.items()]
    sums = [sum(values) for values in zip(*columns, strict=True)]
    return [max(value, 0.0) for value in sums] if min(shares.values()) < 0 else sums


def _put_strip(
    take: Take,
    keys: bpy.types.Key,
    found: dict[str, dict[str, float]],
    scene: bpy.types.Scene,
    first: float,
) -> None:
    frames = [first + time * scene_rate(scene) for time in take.times]
    curves = [(_path(shape), 0, _values(take, shares)) for shape, shares in found.items()]
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
