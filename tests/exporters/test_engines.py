import re
import shutil
import subprocess
import zlib
from dataclasses import replace

import numpy as np
import pytest
from animations import line, only
from avatars import write_vrm1

from phonanim.errors import OutputError, RigError
from phonanim.exporters import load, save
from phonanim.rig.head import SHIPPED
from phonanim.rig.neck import TURNS, quaternions

MOVED = [name for name in line().channels if name not in TURNS]
NAME = "あ: face/b"  # needs quotes in YAML


def unity(path):
    """The curves of a clip as YAML: {(path, attribute): (time, value, slope before, slope after) rows}."""
    yaml = pytest.importorskip("yaml")
    header, text = path.read_text().split("--- !u!74 &7400000\n")
    assert header == "%YAML 1.1\n%TAG !u! tag:unity3d.com,2011:\n"
    clip = yaml.load(text, yaml.CBaseLoader if hasattr(yaml, "CBaseLoader") else yaml.BaseLoader)[
        "AnimationClip"
    ]
    assert clip["m_EditorCurves"] == clip["m_FloatCurves"]
    curves = {}
    for entry in clip["m_FloatCurves"]:
        keys = entry["curve"]["m_Curve"]
        assert entry["classID"] == "137"
        assert {key["tangentMode"] for key in keys} == {"69"}
        rows = [[key[part] for part in ("time", "value", "inSlope", "outSlope")] for key in keys]
        curves[entry["path"], entry["attribute"]] = np.array(rows, float)
    return clip, curves


def test_unity_reads_percents_and_straight_tangents(tmp_path):
    animation = line(frames=20)
    save(animation, tmp_path / "hello.unity.anim", node="Armature/Face", keys=0)
    clip, curves = unity(tmp_path / "hello.unity.anim")
    assert clip["m_Name"] == "hello"
    assert float(clip["m_SampleRate"]) == 60
    assert float(clip["m_AnimationClipSettings"]["m_StopTime"]) == pytest.approx(19 / 60)
    assert set(curves) == {("Armature/Face", f"blendShape.{name}") for name in MOVED}
    times, values, before, after = curves["Armature/Face", "blendShape.jawOpen"].T
    np.testing.assert_allclose(times, animation.times, atol=1e-6)
    np.testing.assert_allclose(values, 100 * animation.channel("jawOpen"), atol=1e-4)
    rise = np.diff(values) / np.diff(times)
    np.testing.assert_allclose(before[1:], rise, rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(after[:-1], rise, rtol=1e-3, atol=1e-3)


def test_unity_finds_shapes_by_the_sums_of_their_names(tmp_path):
    animation = replace(only(line(frames=2), jawOpen=0.5), channels=(NAME, *line().channels[1:]))
    save(animation, tmp_path / "a.unity.anim", node=NAME, keys=0.01)
    clip, curves = unity(tmp_path / "a.unity.anim")
    assert (NAME, f"blendShape.{NAME}") in curves
    bound = clip["m_ClipBindingConstant"]["genericBindings"][0]
    assert int(bound["path"]) == zlib.crc32(NAME.encode())
    assert int(bound["attribute"]) == zlib.crc32(f"blendShape.{NAME}".encode())
    assert all(len(rows) == 1 for rows in curves.values())


def godot(path):
    """The tracks of an animation: {path: (times, values)}."""
    found = {}
    for track in path.read_text().split("\ntracks/")[1:]:
        if "/path" in track.split("\n")[0]:
            name = re.search(r'NodePath\("(.*)"\)', track)[1]
        if "/keys" in track.split("\n")[0]:
            times = re.search(r'"times": PoolRealArray\( (.*) \)', track)[1]
            values = re.search(r'"values": \[ (.*) \]', track)[1]
            assert all(re.search(r"[.e]", value) for value in values.split(", "))  # else an integer
            found[name] = np.array([times.split(", "), values.split(", ")], float)
    return found


def test_godot_moves_properties_of_the_mesh(tmp_path):
    animation = replace(line(), start=-0.5)
    save(animation, tmp_path / "a.tres", node="Armature/Face", keys=0)
    tracks = godot(tmp_path / "a.tres")
    assert set(tracks) == {f"Armature/Face:blend_shapes/{name}" for name in MOVED}
    times, values = tracks["Armature/Face:blend_shapes/jawOpen"]
    np.testing.assert_allclose(times, np.arange(61) / 60, atol=1e-6)
    np.testing.assert_allclose(values, animation.channel("jawOpen"), atol=1e-6)
    save(only(line(), jawOpen=1.0), tmp_path / "a.tres", keys=0.01)
    assert godot(tmp_path / "a.tres")["Skeleton3D/head:blend_shapes/jawOpen"].tolist() == [[0.0], [1.0]]
    with pytest.raises(OutputError, match=r"a\.tres: Godot allows no colon in a path: a:b, "):
        save(line(), tmp_path / "a.tres", node="a:b")


@pytest.mark.parametrize("suffix", [".tres", ".unity.anim", ".a2f.json", ".vrma"])
def test_turns_are_no_shapes_however_they_are_spelt(tmp_path, suffix):
    names = tuple(name[0].upper() + name[1:] for name in line().channels)
    save(replace(line(frames=3), channels=names), tmp_path / f"a{suffix}")
    written = (tmp_path / f"a{suffix}").read_bytes()
    assert b"JawOpen" in written
    assert b"HeadPitch" not in written


def turning_copy(tmp_path):
    """The shipped head as somebody's character, in a take in which its head turns."""
    hero = tmp_path / "hero.glb"
    hero.write_bytes(SHIPPED.read_bytes())
    animation = only(line(), jawOpen=0.5)
    animation.values[:, -3:] = np.linspace(0, 1, len(animation.values))[:, None] * (8.0, -20.0, 5.0)
    turns = quaternions(animation.values[:, -3:].astype(float))
    return hero, animation, turns


def test_unity_turns_the_bone_of_the_head(tmp_path):
    hero, animation, turns = turning_copy(tmp_path)
    save(animation, tmp_path / "a.unity.anim", character=hero, keys=0)
    yaml = pytest.importorskip("yaml")
    clip = yaml.safe_load((tmp_path / "a.unity.anim").read_text().split("&7400000\n")[1])["AnimationClip"]
    (curve,) = clip["m_RotationCurves"]
    assert curve["path"] == "Neck/Head"
    keys = curve["curve"]["m_Curve"]
    found = np.array([[key["value"][part] for part in "xyzw"] for key in keys])
    np.testing.assert_allclose(found, turns * (1, -1, -1, 1), atol=1e-6)
    shown = [one for one in clip["m_EditorCurves"] if one["classID"] == 4]
    assert [one["attribute"] for one in shown] == [f"m_LocalRotation.{part}" for part in "xyzw"]
    bound = clip["m_ClipBindingConstant"]["genericBindings"][-1]
    assert (bound["path"], bound["attribute"], bound["typeID"]) == (zlib.crc32(b"Neck/Head"), 2, 4)
    assert load(tmp_path / "a.unity.anim").channel("jawOpen") == pytest.approx(0.5)


def test_godot_turns_the_bone_of_the_head(tmp_path):
    hero, animation, turns = turning_copy(tmp_path)
    save(animation, tmp_path / "a.tres", character=hero, keys=0)
    last = (tmp_path / "a.tres").read_text().split('type = "rotation_3d"')[1]
    assert 'path = NodePath("Skeleton3D:Head")' in last
    rows = np.array(re.search(r"PoolRealArray\( (.*) \)", last)[1].split(", "), float).reshape(-1, 6)
    np.testing.assert_allclose(rows[:, 0], animation.times, atol=1e-6)
    np.testing.assert_allclose(rows[:, 2:], turns, atol=1e-6)
    save(only(line(), jawOpen=0.5), tmp_path / "b.tres", character=hero)
    assert "rotation_3d" not in (tmp_path / "b.tres").read_text()


@pytest.mark.parametrize("suffix", [".tres", ".unity.anim"])
def test_a_character_names_its_meshes_and_shapes(tmp_path, suffix):
    avatar = write_vrm1(tmp_path / "a.vrm")
    animation = replace(only(line(), jawOpen=0.25), channels=("aa", *line().channels[1:]))
    animation.values[:, 0] = 0.5
    path = tmp_path / f"a{suffix}"
    save(animation, path, character=avatar)
    text = path.read_text()
    assert "head" in text
    if suffix == ".tres":
        moved = godot(path)["Skeleton3D/head:blend_shapes/jawOpen"][1]
        assert moved.max() == 0.75  # by its expression and its name
    save(animation, path, character=avatar, node="Elsewhere")
    assert "Elsewhere" in path.read_text()
    stranger = replace(animation, channels=tuple(f"x{i}" for i in range(len(animation.channels))))
    with pytest.raises(RigError, match=r"has no morph target named like x0"):
        save(stranger, path, character=avatar)


GODOT = shutil.which("godot3-server")


@pytest.mark.skipif(GODOT is None, reason="needs godot3-server")
def test_godot_shows_the_curves(tmp_path, root):
    save(line(), tmp_path / "a.tres", node="Face", keys=0)
    save(line(), tmp_path / "a.json")
    script = root / "scripts" / "check_godot.gd"
    command = [GODOT, "-s", script, "--animation=a.tres", "--take=a.json"]
    done = subprocess.run(
        command,
        cwd=tmp_path,
        env={"PWD": str(tmp_path), "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout
    assert f"{len(MOVED)} tracks" in done.stdout
