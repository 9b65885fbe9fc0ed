"""phonanim in Blender: speech on shape keys, as NLA strips that can be edited and made again."""

import bpy

from .operators import OPERATORS


class Preferences(bpy.types.AddonPreferences):
    """Where phonanim is."""

    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="phonanim",
        description="The program; empty for the one on PATH or in Blender's Python",
        subtype="FILE_PATH",
        default="",
    )

    def draw(self, context: bpy.types.Context) -> None:
        """One field."""
        self.layout.prop(self, "program")


class Panel(bpy.types.Panel):
    """The operators in the sidebar of the 3D view."""

    bl_idname = "VIEW3D_PT_phonanim"
    bl_label = "phonanim"
    bl_category = "phonanim"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"

    def draw(self, context: bpy.types.Context) -> None:
        """A button for each operator."""
        for operator in OPERATORS:
            self.layout.operator(operator.bl_idname)


CLASSES = (Preferences, *OPERATORS, Panel)


def register() -> None:
    """Called by Blender when the add-on is switched on."""
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister() -> None:
    """Called by Blender when the add-on is switched off."""
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
