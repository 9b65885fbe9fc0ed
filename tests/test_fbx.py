"""A line goes through FBX by Blender, is corrected there, and keeps the correction in a slower take."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.exporters import load
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

BLENDER = os.environ.get("BLENDER_PYTHON") or (sys.executable if importlib.util.find_spec("bpy") else "")
FIRST, LAST = 115, 125  # frames in which the jaw opens further
EDIT = f"""
import sys
sys.path.insert(0, sys.argv[1])
import bpy
import fbx_through_blender as through

write = bpy.ops.export_scene.fbx
through.convert("line.glb", "line.fbx", 60)
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.fps = 60
bpy.ops.import_scene.fbx(filepath="line.fbx")
(key,) = (key for key in bpy.data.shape_keys if "jawOpen" in key.key_blocks)
jaw = key.key_blocks["jawOpen"]
for frame in range({FIRST} + 1, {LAST} + 1):  # Blender reads the first frame as frame 1
    bpy.context.scene.frame_set(frame)
    jaw.value += 0.2
    jaw.keyframe_insert("value", frame=frame)
scene = bpy.context.scene
scene.frame_start, scene.frame_end = 1, 272
write(filepath="edited.fbx", bake_anim=True, bake_anim_use_nla_strips=False, bake_anim_use_all_actions=False,
      bake_anim_simplify_factor=0.0, add_leaf_bones=False)
through.convert("edited.fbx", "edited.glb", 60)
"""


@pytest.mark.slow
@pytest.mark.skipif(not BLENDER, reason="needs Blender's Python package, bpy, or BLENDER_PYTHON")
def test_a_correction_in_fbx_survives_a_slower_take(root, tmp_path, monkeypatch):
    shutil.copy(root / "examples/line.TextGrid", tmp_path)
    monkeypatch.chdir(tmp_path)
    assert run(["animate", "line.TextGrid", "-o", "line.glb", "--life", "0", "-q"]) == 0
    given = [BLENDER, "-c", EDIT, str(root / "examples")]
    done = subprocess.run(given, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert run(["edit", "diff", "line.glb", "edited.glb", "-o", "line.edits.json", "-q"]) == 0
    (edit,) = json.loads((tmp_path / "line.edits.json").read_text())["edits"]  # and nothing else has changed
    assert edit["channel"] == "jawOpen"

    base = load(tmp_path / "line.glb")
    phones = [Interval(p.label, 1.15 * p.start, 1.15 * p.end) for p in base.phones]
    write_textgrid(tmp_path / "again.TextGrid", {"phones": phones}, 1.15 * float(base.times[-1]))
    for name, more in (("plain", []), ("again", ["--edits", "line.edits.json"])):
        assert run(["animate", "again.TextGrid", "-o", f"{name}.json", "--life", "0", "-q", *more]) == 0
    change = load(tmp_path / "again.json").channel("jawOpen") - load(tmp_path / "plain.json").channel(
        "jawOpen"
    )
    at = np.flatnonzero(change > 0.15) / 60
    assert (at.min(), at.max()) == pytest.approx((1.15 * FIRST / 60, 1.15 * LAST / 60), abs=0.1)
