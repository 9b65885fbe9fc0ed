"""The Blender add-on: what needs no Blender here, and all of it where Blender's Python package is."""

import importlib.util
import json
import os
import subprocess
import sys
import zipfile
from dataclasses import replace
from types import ModuleType

import pytest
from animations import line

import phonanim
from phonanim.exporters import save
from phonanim.rig.names import match_shapes, plain_name

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

BLENDER = os.environ.get("BLENDER_PYTHON") or (sys.executable if importlib.util.find_spec("bpy") else "")


def load(path, name):
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def installed(package, tmp_path_factory):
    """The add-on as a package without what needs Blender, unpacked from its zip."""
    folder = tmp_path_factory.mktemp("addon")
    with zipfile.ZipFile(package) as archive:
        archive.extractall(folder)
    sys.modules["phonanim_addon"] = ModuleType("phonanim_addon")
    sys.modules["phonanim_addon"].__path__ = [str(folder)]
    return folder


@pytest.fixture(scope="module")
def takes(installed):
    return load(installed / "takes.py", "phonanim_addon.takes")


@pytest.fixture(scope="module")
def names(installed, takes):
    return load(installed / "names.py", "phonanim_addon.names")


@pytest.fixture(scope="module")
def package(root, tmp_path_factory):
    build = load(root / "scripts/build_blender_addon.py", "build_blender_addon").build
    paths = [build(tmp_path_factory.mktemp("dist")) for _ in range(2)]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    return paths[0]


def test_the_package_has_a_manifest_and_nothing_heavy(package):
    with zipfile.ZipFile(package) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        names = set(archive.namelist())
        license_text = archive.read("LICENSE").decode()
    assert {name for name in names if not name.startswith("names/")} == {
        *("__init__.py", "faces.py", "names.py", "necks.py", "operators.py", "programs.py", "scenes.py"),
        *("strips.py", "takes.py", "blender_manifest.toml", "LICENSE"),
    }
    assert "names/vroid.csv" in names
    assert manifest["version"] == phonanim.__version__
    assert package.name == f"{manifest['id']}-{manifest['version']}.zip"
    assert manifest["license"] == ["SPDX:MIT"]
    assert "MIT License" in license_text
    assert package.stat().st_size < 40_000


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


def test_names_match_as_in_the_exporters(names):
    for name in (
        "jawOpen",
        "BS.jaw_open",
        "eyeBlink_L",
        "eyeBlink.L",
        "mouthRoll",
        "L",
        "aaR",
        "jaw-open.001",
    ):
        assert names.plain_name(name) == plain_name(name), name


def test_shapes_are_those_that_the_exporters_move(root, names):
    conventions = {
        "vroid": (["Fcl_MTH_A", "Fcl_MTH_O", "Fcl_ALL_Joy"], ["aa", "ih", "ou", "ee", "oh"]),
        "one shape": (["mouthOpen", "mouthSmile"], list(line().channels)),
        "arkit": (["Head.jawOpen", "BS_MouthLeft", "eyeBlink.L"], list(line().channels)),
    }
    for shapes, channels in conventions.values():
        rows = match_shapes(tuple(shapes), tuple(channels), frozenset(shapes), "a.glb")
        expected = {(channels[column], shapes[row]): share for column, row, share in rows}
        found = names.match_shapes(channels, shapes, {})
        moved = {
            (channel, shape): share for shape, shares in found.items() for channel, share in shares.items()
        }
        assert moved == expected
        assert moved


def test_a_table_of_ones_own_comes_first(tmp_path, names, takes):
    (tmp_path / "names.csv").write_text("\ufeffshape,control,weight\nOpen,jawOpen,0.5\n", "utf-8")
    own = names.read_names([tmp_path / "names.csv"])
    found = names.match_shapes(["jawOpen", "mouthLeft"], ["jawOpen", "Open", "mouthLeft", "MouthLeft"], own)
    assert found == {"Open": {"jawOpen": 0.5}, "mouthLeft": {"mouthLeft": 1.0}}
    (tmp_path / "names.csv").write_text("jawOpen,Open\n")
    with pytest.raises(takes.TakeError, match=r"is not a table shape,control,weight"):
        names.read_names([tmp_path / "names.csv"])


@pytest.mark.slow
@pytest.mark.skipif(not BLENDER, reason="needs Blender's Python package, bpy, or BLENDER_PYTHON")
def test_from_installation_to_edits(root, package):
    script, head = root / "scripts/check_blender_addon.py", root / "lexicon/rigs/head.glb"
    done = subprocess.run(
        [BLENDER, script, package, head, root / "examples/line.TextGrid"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert "the add-on does what it should" in done.stdout
