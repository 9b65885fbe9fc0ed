"""The operators: import a line, animate an alignment, animate a folder, export edits."""

import json
import tempfile
from collections.abc import Callable
from pathlib import Path

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from .faces import find_faces, put_take, read_back, scene_rate
from .names import Table, read_names
from .necks import TURNS, put_turns
from .programs import run_phonanim
from .scenes import lay_sound, mark_phones
from .takes import FORMATS, Take, TakeError, read_take

ALIGNMENTS = (".textgrid", ".lab", ".ctm", ".tsv", ".srt", ".vtt", ".eaf")


def told(execute: Callable[..., str]) -> Callable[..., set[str]]:
    """An operator's `execute` that reports what it returns, or the one line of a TakeError."""

    def wrapped(self: bpy.types.Operator, context: bpy.types.Context) -> set[str]:
        try:
            self.report({"INFO"}, execute(self, context))
        except TakeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    return wrapped


def program(context: bpy.types.Context) -> str:
    """The program that the preferences name, empty for none."""
    addon = context.preferences.addons.get(__package__)
    return bpy.path.abspath(addon.preferences.program) if addon and addon.preferences else ""


def names_of(operator: bpy.types.Operator) -> Table:
    """The table of names that an operator was given."""
    return read_names([Path(bpy.path.abspath(operator.names))]) if operator.names else {}


def lay(
    operator: bpy.types.Operator, context: bpy.types.Context, take: Take, folder: Path, first: float
) -> str:
    """Put a take, whose sound is in `folder`, on the selected meshes, and say what it moves."""
    scene = context.scene
    faces = find_faces(context.selected_objects)
    moved, left = put_take(take, faces, scene, names_of(operator), first)
    heads = put_turns(take, context.selected_objects, scene_rate(scene), first) if operator.head else 0
    phones = mark_phones(take, scene, first) if operator.markers else 0
    sound = operator.sound and lay_sound(take, folder, scene, first)
    left = [name for name in left if not (heads and name in TURNS)]
    without = f"; no shape key for {', '.join(left)}" if left else ""
    told = f"{moved} shape keys and {heads} heads move, {phones} markers, {'its' if sound else 'no'} sound"
    return f"{take.name}: {told}{without}"


class Laid:
    """What the operators that lay lines on meshes ask for."""

    names: StringProperty(
        name="Names", description="Table shape,control,weight of own names", subtype="FILE_PATH", default=""
    )
    markers: BoolProperty(name="Markers", description="A marker at the start of each phone", default=True)
    head: BoolProperty(name="Head", description="Turn the head bone of the meshes' armature", default=True)
    sound: BoolProperty(name="Sound", description="The recording, in the sequencer", default=True)
    first: FloatProperty(name="Frame", description="The frame of time zero", default=0.0)


class ImportLine(Laid, bpy.types.Operator, ImportHelper):
    """Import an animation as a strip on the shape keys of the selected meshes."""

    bl_idname = "phonanim.import_line"
    bl_label = "Import line"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    filter_glob: StringProperty(default="*.json;*.csv;*.npz;*.glb;*.usda;*.vrma;*.vmd", options={"HIDDEN"})

    @told
    def execute(self, context: bpy.types.Context) -> str:
        """Read the file, by phonanim where it is not JSON."""
        path = Path(self.filepath)
        if path.suffix.lower() in FORMATS:
            return lay(self, context, read_take(path), path.parent, self.first)
        with tempfile.TemporaryDirectory() as folder:
            plain = Path(folder) / f"{path.stem}.json"
            run_phonanim(program(context), "convert", str(path), "-o", str(plain))
            return lay(self, context, read_take(plain), path.parent, self.first)


class Animated(Laid):
    """What the operators that animate alignments ask for."""

    rig: StringProperty(name="Rig", description="A rig of phonanim, or a file", default="arkit")
    options: StringProperty(name="Options", description="More options of phonanim animate", default="")

    def animate(self, context: bpy.types.Context, path: Path, edits: str, first: float) -> tuple[Take, str]:
        """Animate an alignment at the scene's rate, and lay it on the selected meshes."""
        find_faces(context.selected_objects)
        with tempfile.TemporaryDirectory() as folder:
            plain = Path(folder) / f"{path.stem}.json"
            rate = f"{scene_rate(context.scene):.6f}"
            more = [*(["--edits", bpy.path.abspath(edits)] if edits else []), *self.options.split()]
            run_phonanim(
                program(context),
                "animate",
                str(path),
                "-o",
                str(plain),
                "--rig",
                self.rig,
                "--fps",
                rate,
                *more,
            )
            take = read_take(plain)
        return take, lay(self, context, take, path.parent, first)


class AnimateAlignment(Animated, bpy.types.Operator, ImportHelper):
    """Animate an alignment by phonanim, with the edits of an earlier take."""

    bl_idname = "phonanim.animate"
    bl_label = "Animate alignment"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    edits: StringProperty(
        name="Edits", description="Edits of an earlier take to do again", subtype="FILE_PATH", default=""
    )

    @told
    def execute(self, context: bpy.types.Context) -> str:
        """Animate, and lay the line on the meshes."""
        return self.animate(context, Path(self.filepath), self.edits, self.first)[1]


class AnimateFolder(Animated, bpy.types.Operator):
    """Animate every alignment of a folder, one line after another."""

    bl_idname = "phonanim.animate_folder"
    bl_label = "Animate folder"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    directory: StringProperty(subtype="DIR_PATH")
    gap: FloatProperty(name="Gap", description="Seconds between lines", default=1.0, min=0.0)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the folder."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    @told
    def execute(self, context: bpy.types.Context) -> str:
        """Animate each line; its edits are those of the same name beside it."""
        folder, first = Path(bpy.path.abspath(self.directory)), self.first
        lines = sorted(one for one in folder.glob("*") if one.suffix.lower() in ALIGNMENTS)
        if not lines:
            raise TakeError(f"{folder}: has no alignment ({' '.join(ALIGNMENTS)})")
        for path in lines:
            edits = path.with_name(f"{path.stem}.edits.json")
            take, _ = self.animate(context, path, str(edits) if edits.is_file() else "", first)
            first += (take.times[-1] + self.gap) * scene_rate(context.scene)
        return f"{len(lines)} lines, to frame {first:.0f}"


class ExportEdits(bpy.types.Operator, ExportHelper):
    """Export what was changed in a line's curves as a file of edits, for its next take."""

    bl_idname = "phonanim.export_edits"
    bl_label = "Export edits"
    filename_ext = ".edits.json"

    filter_glob: StringProperty(default="*.edits.json", options={"HIDDEN"})
    line: StringProperty(name="Line", description="The line; empty for the last", default="")
    replace: BoolProperty(name="Replace", description="Keep the curves themselves, not their differences")

    @told
    def execute(self, context: bpy.types.Context) -> str:
        """Compare the curves with the take that was laid on the active mesh."""
        (face,) = find_faces([context.active_object] if context.active_object else [])
        base, edited, lost = read_back(face, context.scene, self.line)
        with tempfile.TemporaryDirectory() as folder:
            places = [Path(folder) / name for name in ("base.json", "edited.json")]
            for place, take in zip(places, (base, edited), strict=True):
                place.write_text(json.dumps(take.document), "utf-8")
            more = ["--replace"] if self.replace else []
            run_phonanim(program(context), "edit", "diff", *map(str, places), "-o", self.filepath, *more)
        found = json.loads(Path(self.filepath).read_text("utf-8"))["edits"]
        without = f"; not of {', '.join(lost)}, which several controls move" if lost else ""
        return f"{self.filepath}: {len(found)} edits of {base.name}{without}"


OPERATORS = (ImportLine, AnimateAlignment, AnimateFolder, ExportEdits)
