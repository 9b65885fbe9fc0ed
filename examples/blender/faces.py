"""Takes on the shape keys of meshes: an action and an NLA strip for each mesh, markers for phones."""

import json

import bpy

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


def mark_phones(take: Take, scene: bpy.types.Scene, first: float) -> int:
    """A marker at the start of each phone; those of an earlier take of this name go."""
    listed = json.loads(scene.get(KEPT, "{}"))  # markers have no custom properties
    before = {tuple(one) for one in listed.get(take.name, [])}
    for marker in [one for one in scene.timeline_markers if (one.name, one.frame) in before]:
        scene.timeline_markers.remove(marker)
    rate = scene_rate(scene)
    spoken = [(label, round(first + start * rate)) for label, start, _ in take.phones if label]
    made = [scene.timeline_markers.new(label, frame=frame) for label, frame in spoken]
    scene[KEPT] = json.dumps({**listed, take.name: [(one.name, one.frame) for one in made]})
    return len(made)


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
    data = keys.animation_data or keys.animation_data_create()
    for track in [one for one in data.nla_tracks if one.name == take.name]:
        data.nla_tracks.remove(track)
    action = bpy.data.actions.new(f"{take.name} {keys.name}")
    slot = action.slots.new(id_type="KEY", name=keys.name)
    bag = action.layers.new("speech").strips.new(type="KEYFRAME").channelbag(slot, ensure=True)
    rate = scene_rate(scene)
    frames = [first + time * rate for time in take.times]
    for channel, shape in found.items():
        curve = bag.fcurves.new(_path(shape))
        curve.keyframe_points.add(len(frames))
        pairs = zip(frames, take.curves[channel], strict=True)
        curve.keyframe_points.foreach_set("co", [number for pair in pairs for number in pair])
        linear = bpy.types.Keyframe.bl_rna.properties["interpolation"].enum_items["LINEAR"].value
        curve.keyframe_points.foreach_set("interpolation", [linear] * len(frames))
        curve.update()
    kept = {"name": take.name, "document": take.document, "shapes": found, "first": first}
    action[KEPT] = json.dumps(kept)
    _add_strip(data, take.name, action, slot, frames)


def _add_strip(
    data: bpy.types.AnimData,
    name: str,
    action: bpy.types.Action,
    slot: bpy.types.ActionSlot,
    frames: list[float],
) -> None:
    track = data.nla_tracks.new()
    track.name = name
    strip = track.strips.new(name, int(frames[0]), action)
    strip.action_slot = slot
    strip.action_frame_start, strip.action_frame_end = frames[0], max(frames[-1], frames[0] + 1)
    strip.frame_start, strip.frame_end = frames[0], max(frames[-1], frames[0] + 1)
    strip.extrapolation = "NOTHING"


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
