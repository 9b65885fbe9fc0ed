"""An action of a take and its NLA strip, on whatever has animation: shape keys, armatures."""

from collections.abc import Sequence

import bpy

Curve = tuple[str, int, Sequence[float]]  # path of the property, place in it, a value for each frame


def lay_strip(owner: bpy.types.ID, name: str, frames: list[float], curves: list[Curve]) -> bpy.types.Action:
    """Key properties at frames, straight between, in a strip called `name`; one of this name is replaced."""
    data = owner.animation_data or owner.animation_data_create()
    for track in [one for one in data.nla_tracks if one.name == name]:
        data.nla_tracks.remove(track)
    action = bpy.data.actions.new(f"{name} {owner.name}")
    slot = action.slots.new(id_type=owner.id_type, name=owner.name)
    bag = action.layers.new("speech").strips.new(type="KEYFRAME").channelbag(slot, ensure=True)
    linear = bpy.types.Keyframe.bl_rna.properties["interpolation"].enum_items["LINEAR"].value
    for path, place, values in curves:
        curve = bag.fcurves.new(path, index=place)
        curve.keyframe_points.add(len(frames))
        pairs = zip(frames, values, strict=True)
        curve.keyframe_points.foreach_set("co", [number for pair in pairs for number in pair])
        curve.keyframe_points.foreach_set("interpolation", [linear] * len(frames))
        curve.update()
    track = data.nla_tracks.new()
    track.name = name
    strip = track.strips.new(name, int(frames[0]), action)
    strip.action_slot = slot
    first, last = frames[0], max(frames[-1], frames[0] + 1)
    strip.action_frame_start, strip.action_frame_end = first, last
    strip.frame_start, strip.frame_end = first, last
    strip.extrapolation = "NOTHING"
    return action
