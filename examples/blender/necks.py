"""Turns of the head on the bone of an armature.

Turns are degrees about axes of the character: pitch down, yaw to its left, roll to its right shoulder; roll
is done first and yaw last. In Blender a character looks along -y, z is up, and x is its left.
"""

import math
import re

import bpy
from mathutils import Quaternion, Vector

from .strips import lay_strip
from .takes import Take

TURNS = ("headPitch", "headYaw", "headRoll")
AXES = (Vector((1, 0, 0)), Vector((0, 0, 1)), Vector((0, -1, 0)))  # of pitch, yaw, roll
BONE = re.compile(r"(^|[:_.\s])head$", re.IGNORECASE)


def find_necks(objects: list[bpy.types.Object]) -> list[tuple[bpy.types.Object, bpy.types.PoseBone]]:
    """The armatures that are among objects or move them, each with the bone of its head."""
    armatures: dict[str, bpy.types.Object] = {}
    for one in objects:
        movers = [modifier.object for modifier in one.modifiers if modifier.type == "ARMATURE"]
        for armature in (one, one.parent, *movers):
            if armature is not None and armature.type == "ARMATURE":
                armatures[armature.name] = armature
    found = [(one, [bone for bone in one.pose.bones if BONE.search(bone.name)]) for one in armatures.values()]
    return [(one, bones[0]) for one, bones in found if bones]


def put_turns(take: Take, objects: list[bpy.types.Object], rate: float, first: float) -> int:
    """Lay the turns of a take on the heads of armatures; how many heads turn."""
    turns = [take.curves.get(name) or [0.0] * len(take.times) for name in TURNS]
    necks = find_necks(objects) if any(any(curve) for curve in turns) else []
    frames = [first + time * rate for time in take.times]
    for armature, bone in necks:
        rest = (armature.matrix_world @ bone.bone.matrix_local).to_quaternion()
        rotations = [rest.inverted() @ _turn(degrees) @ rest for degrees in zip(*turns, strict=True)]
        bone.rotation_mode = "QUATERNION"
        path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"].rotation_quaternion'
        curves = [(path, place, [one[place] for one in rotations]) for place in range(4)]
        lay_strip(armature, take.name, frames, curves)
    return len(necks)


def _turn(degrees: tuple[float, ...]) -> Quaternion:
    pitch, yaw, roll = (
        Quaternion(axis, math.radians(angle)) for axis, angle in zip(AXES, degrees, strict=True)
    )
    return yaw @ pitch @ roll
