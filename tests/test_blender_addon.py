"""The Blender add-on: what needs no Blender here, and all of it where Blender's Python package is."""

import importlib.util
import json
import os
import subprocess
import sys
import zipfile
from dataclasses import replace

import pytest
from animations import line

import phonanim
from phonanim.exporters import save
from phonanim.rig.morphs import plain_name

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

BLENDER = os.environ.get("BLENDER_PYTHON") or (sys.executable if importlib.util.find_spec("bpy") else "")


def load(path):
    spec = importlib.util.spec_from_file_location(f"addon_{path.stem}", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def takes(root):
    return load(root / "examples/blender/takes.py")


@pytest.fixture(scope="module")
def package(root, tmp_path_factory):
    build = load(root / "scripts/build_blender_addon.py").build
    paths = [build(tmp_path_factory.mktemp("dist")) for _ in range(2)]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    return paths[0]


def test_the_package_has_a_manifest_and_nothing_heavy(package):
    with zipfile.ZipFile(package) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        names = set(archive.namelist())
        license_text = archive.read("LICENSE").decode()
    assert names == {
        *("__init__.py", "faces.py", "necks.py", "operators.py", "programs.py", "scenes.py", "strips.py"),
        *("takes.py", "blender_manifest.toml", "LICENSE"),
    }
    assert manifest["version"] == phonanim.__version__
    assert package.name == f"{manifest['id']}-{manifest['version']}.zip"
    assert manifest["license"] == ["SPDX:MIT"]
    assert "MIT License" in license_text
    assert package.stat().st_size < 20_000


@pytest.mark.parametrize("suffix", [".json", ".track.json"])
def test_takes_are_read(tmp_path, takes, suffix):
    animation = replace(line(), start=0.0 if "track" in suffix else 0.25)
    path = tmp_path / f"hello{suffix}"
    save(animation, path)
    take = takes.read_take(path)
    assert take.name == "hello"
    assert take.times == pytest.approx(animation.times.tolist())
    assert take.curves["jawOpen"] == pytest.approx(animation.channel("jawOpen").tolist(), abs=0.004)
    assert len(take.phones) == (0 if "track" in suffix else 6)


UNEVEN = {"format": "phonanim animation 1", "fps": 30, "start": 0, "curves": {"a": [1], "b": []}}
STRANGE = ("", "[]", "{}", '{"format": "x"}', '{"format": "openfacefx.track"}', json.dumps(UNEVEN))


@pytest.mark.parametrize("text", STRANGE)
def test_files_that_are_no_takes(tmp_path, takes, text):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(takes.TakeError, match=r"a\.json: "):
        takes.read_take(path)


def test_names_match_as_in_the_exporters_and_as_blender_changes_them(takes):
    for name in ("jawOpen", "BS.jaw_open", "eyeBlink_L", "mouthRoll", "eyeBlinkR", "L", "aaR", "Jaw Open"):
        assert takes.plain_name(name) == plain_name(name), name
    assert takes.plain_name("jawOpen.001") == takes.plain_name("jawOpen_001") == "jawopen"
    assert takes.plain_name("eyeBlink.L") == "eyeblinkleft"


def test_shapes_by_table_name_and_plain_name(tmp_path, takes):
    (tmp_path / "names.csv").write_text("\ufeff# channel, shape\njawOpen, Open\n", "utf-8")
    names = takes.read_names(tmp_path / "names.csv")
    shapes = ["jawOpen", "Open", "Mouth_Smile_L", "mouthLeft", "MouthLeft"]
    found = takes.match_shapes(["jawOpen", "mouthSmileLeft", "mouthLeft", "cheekPuff"], shapes, names)
    assert found == {"jawOpen": "Open", "mouthSmileLeft": "Mouth_Smile_L", "mouthLeft": "mouthLeft"}
    (tmp_path / "names.csv").write_text("jawOpen\n")
    with pytest.raises(takes.TakeError, match=r"is not a table of two columns, channel and shape"):
        takes.read_names(tmp_path / "names.csv")


@pytest.mark.slow
@pytest.mark.skipif(not BLENDER, reason="needs Blender's Python package, bpy, or BLENDER_PYTHON")
def test_from_installation_to_edits(root, package):
    script, head = root / "scripts/check_blender_addon.py", root / "lexicon/rigs/head.glb"
    done = subprocess.run(
        [BLENDER, script, package, head, root / "examples/line.TextGrid"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert "the add-on does what it should" in done.stdout
