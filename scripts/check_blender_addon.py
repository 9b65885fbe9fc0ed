"""Check the add-on in Blender, from its installation to edits that survive a new take.

Blender's package has an environment of its own, as for check_blender.py; phonanim is on PATH:

    python scripts/build_blender_addon.py -o dist
    blender/bin/python scripts/check_blender_addon.py dist/phonanim-0.1.0.zip lexicon/rigs/head.glb a.TextGrid

Blender's settings are in a temporary folder. Ends with status 1 when something is not as it should be.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

FOLDER = Path(tempfile.mkdtemp(prefix="phonanim-blender-"))
os.environ["BLENDER_USER_RESOURCES"] = str(FOLDER / "user")

import bpy  # noqa: E402  after its folder of settings is set
import numpy as np  # noqa: E402
from check_blender import head_turns  # noqa: E402

TOLERANCE, EDITED, TURN_TOLERANCE = 1e-6, 5e-3, 1e-3
TURNS = ("headPitch", "headYaw", "headRoll")
RATE = 30


def main() -> None:
    """Install, import, animate, edit, animate again, animate a folder."""
    package, head, alignment = (Path(argument).resolve() for argument in sys.argv[1:])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(
        filepath=str(package), repo="user_default", enable_on_install=True
    )
    scene = bpy.context.scene
    scene.render.fps = RATE
    fails("select a mesh that has shape keys", bpy.ops.phonanim.animate, filepath=str(alignment))
    bpy.ops.import_scene.gltf(filepath=str(head))
    face = next(one for one in bpy.data.objects if one.type == "MESH" and one.data.shape_keys)
    scene.render.fps = RATE  # the importer may have changed it
    bpy.ops.object.select_all(action="DESELECT")
    face.select_set(True)
    bpy.context.view_layer.objects.active = face
    face.data.shape_keys.key_blocks["jawOpen"].name = "Opener"  # known by the table alone, and twice as far
    face.data.shape_keys.key_blocks["eyeBlinkLeft"].name = "eyeBlink.L"
    names = FOLDER / "names.csv"
    names.write_text("shape,control,weight\nOpener,jawOpen,0.5\n")
    check_animation(face, alignment, names)
    check_edits(face, alignment, names)
    check_folder(face, alignment, names)
    check_import(face, alignment, names)
    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.phonanim")
    assert not hasattr(bpy.types, "VIEW3D_PT_phonanim")
    shutil.rmtree(FOLDER)
    print(f"Blender {bpy.app.version_string}: the add-on does what it should")


def check_animation(face: bpy.types.Object, alignment: Path, names: Path) -> None:
    """The strip of an alignment shows phonanim's curves, and phones have markers."""
    bpy.ops.phonanim.animate(filepath=str(alignment), names=str(names), first=11.0)
    told = animate(alignment)
    worst = largest_difference(face, told, 11.0)
    assert worst < TOLERANCE, worst
    spoken = [label for label, _, _ in told["phones"] if label]
    assert [marker.name for marker in bpy.context.scene.timeline_markers] == spoken
    print(f"{len(told['curves'])} curves, largest difference {worst:.1e}, {len(spoken)} markers")
    (sound,) = bpy.context.scene.sequence_editor.strips
    assert (sound.name, sound.frame_start) == (alignment.stem, 11)
    turned = 0.0
    for n in range(told["frames"]):
        bpy.context.scene.frame_set(11 + n)
        wanted = [told["curves"][name][n] for name in TURNS]
        turned = max(turned, float(np.abs(head_turns() - np.array(wanted)).max()))
    assert 0 < turned < TURN_TOLERANCE, turned
    print(f"the head turns by the curves within {turned:.1e} degrees")


def check_edits(face: bpy.types.Object, alignment: Path, names: Path) -> None:
    """What is changed in a curve is exported, and is there again after the line is made again."""
    scene = bpy.context.scene
    (track,) = face.data.shape_keys.animation_data.nla_tracks
    action = track.strips[0].action
    curves = action.layers[0].strips[0].channelbags[0].fcurves
    curve = next(one for one in curves if "Opener" in one.data_path)
    for point in curve.keyframe_points:
        if 41 <= point.co[0] <= 61:
            point.co[1] += 0.2
    curve.update()
    edited = [curve.evaluate(frame) for frame in range(11, 131)]
    sidecar = FOLDER / "line.edits.json"
    bpy.ops.phonanim.export_edits(filepath=str(sidecar))
    edits = json.loads(sidecar.read_text())["edits"]
    assert {edit["channel"] for edit in edits} == {"jawOpen"}, edits
    bpy.ops.phonanim.animate(filepath=str(alignment), names=str(names), first=11.0, edits=str(sidecar))
    tracks = face.data.shape_keys.animation_data.nla_tracks
    assert [one.name for one in tracks] == [alignment.stem]
    worst = 0.0
    for place, value in enumerate(edited):
        scene.frame_set(11 + place)
        worst = max(worst, abs(face.data.shape_keys.key_blocks["Opener"].value - value))
    assert worst < EDITED, worst
    print(f"{len(edits)} edits; after the new take the curve differs from the edited one by {worst:.1e}")


def check_folder(face: bpy.types.Object, alignment: Path, names: Path) -> None:
    """Lines of a folder follow each other."""
    folder = FOLDER / "lines"
    folder.mkdir()
    fails("has no alignment", bpy.ops.phonanim.animate_folder, directory=str(folder))
    for name in ("one", "two"):
        shutil.copy(alignment, folder / f"{name}{alignment.suffix}")
    bpy.ops.phonanim.animate_folder(directory=str(folder), names=str(names), first=200.0, gap=0.5)
    tracks = {one.name: one.strips[0] for one in face.data.shape_keys.animation_data.nla_tracks}
    assert set(tracks) == {alignment.stem, "one", "two"}
    assert abs(tracks["two"].frame_start - tracks["one"].frame_end - 0.5 * RATE) < 0.01
    print("a folder of two lines")


def check_import(face: bpy.types.Object, alignment: Path, names: Path) -> None:
    """Files of other formats come in through phonanim, tracks by themselves."""
    for name in ("line.track.json", "line.npz"):
        animate(alignment, FOLDER / name)
        bpy.ops.phonanim.import_line(filepath=str(FOLDER / name), names=str(names), first=1000.0)
        face.data.shape_keys.animation_data.nla_tracks["line"].strips[0].mute = True
    (FOLDER / "bad.json").write_text("{}")
    fails("is not an animation of phonanim", bpy.ops.phonanim.import_line, filepath=str(FOLDER / "bad.json"))
    print("a track and an archive imported")


def animate(alignment: Path, output: Path | None = None) -> dict:
    """What phonanim itself makes of the alignment, written to a file; its content if it is JSON."""
    output = output or FOLDER / "told.json"
    command = ["phonanim", "animate", alignment, "-o", output, "--rig", "arkit", "--fps", str(RATE)]
    subprocess.run(command, check=True, capture_output=True)
    return json.loads(output.read_text()) if output.suffix == ".json" else {}


def largest_difference(face: bpy.types.Object, told: dict, first: float) -> float:
    """Of the values of shape keys at every frame from those of an animation."""
    renamed = {"jawOpen": "Opener", "eyeBlinkLeft": "eyeBlink.L"}
    blocks, worst = face.data.shape_keys.key_blocks, 0.0
    for n in range(told["frames"]):
        bpy.context.scene.frame_set(int(first) + n)
        for channel, curve in told["curves"].items():
            if channel in TURNS:
                continue
            share = 0.5 if channel == "jawOpen" else 1
            worst = max(worst, abs(blocks[renamed.get(channel, channel)].value - share * curve[n]))
    return worst


def fails(message: str, operator: Callable[..., object], **options: object) -> None:
    """Check that an operator ends with this message."""
    said = ""
    try:
        operator(**options)
    except RuntimeError as error:
        said = str(error)
    assert message in said, said or f"it did not say {message!r}"


if __name__ == "__main__":
    main()
