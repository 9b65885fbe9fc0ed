import json
import os
import re
from dataclasses import replace
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from animations import line, metahuman, vowels

from phonanim import exporters
from phonanim.articulation import CHANNELS
from phonanim.errors import MissingExtraError, OutputError
from phonanim.exporters import find_exporter, formats, load, option_names, save, suffixes
from phonanim.exporters._document import document
from phonanim.exporters.npz import save_arrays
from phonanim.rig.head import SHIPPED
from phonanim.rig.neck import TURNS

# What a format cannot do without, or does faster with.
OPTIONS = {".vrm": {"character": SHIPPED}, ".mp4": {"size": 64}}
FOLDER = Path(exporters.__file__).parent


# Packages without which a suffix cannot be written, or read.
WRITING = {".usdc": "pxr", ".mp4": "av"}
READING = {".usda": "pxr", ".usdc": "pxr", ".curves.usda": "pxr"}


def marked(needed, found):
    """The suffixes as parameters; those whose package is absent are skipped visibly."""
    for suffix in found:
        absent = suffix in needed and find_spec(needed[suffix]) is None
        skip = pytest.mark.skipif(absent, reason=f"{suffix} needs the package {needed.get(suffix)}")
        yield pytest.param(suffix, marks=skip)


WRITABLE = list(marked(WRITING, suffixes()))


def line_for(suffix, **options):
    makers = {".metahuman.csv": metahuman, ".vmd": vowels}
    return makers.get(suffix, line)(**options)


def test_the_folder_is_the_registry():
    stems = {path.stem for path in FOLDER.glob("*.py") if not path.stem.startswith("_")}
    assert {suffix[1:].replace(".", "_") for suffix in suffixes()} == stems
    for suffix, summary in formats().items():
        module = find_exporter(Path("a" + suffix))
        assert callable(module.write)
        assert module.__doc__
        assert len(summary) < 100


def test_the_longest_suffix_wins_in_any_case():
    assert find_exporter(Path("a.b.CSV")).__name__ == "phonanim.exporters.csv"
    with pytest.raises(
        OutputError, match=r"a\.xyz: no format has this suffix; end the name with .*\.csv .*\.npz"
    ):
        find_exporter(Path("a.xyz"))
    with pytest.raises(OutputError, match=r"no format has this suffix"):
        find_exporter(Path(".csv"))


READABLE = [suffix for suffix in suffixes() if hasattr(find_exporter(Path("a" + suffix)), "read")]
# What a value may lose on the way: CSV has ten decimals, JSON six, a track is keyed, turns of the head become
# radians or quaternions; the others lose nothing.
DIGITS = {
    **{".csv": 1e-8, ".glb": 1e-6, ".gltf": 1e-6, ".vrm": 1e-6, ".vrma": 1e-6},
    **{".metahuman.csv": 1e-6, ".json": 1e-6, ".a2f.json": 1e-6, ".vmd": 1e-6, ".track.json": 0.004},
    **{".curves.csv": 1e-6, ".anim": 1e-6, ".unity.anim": 0.002 + 1e-6},
}
STILL = {
    ".usda": TURNS,
    ".curves.usda": TURNS,
    ".unity.anim": TURNS,
    ".usdc": TURNS,
    ".a2f.json": TURNS,
}  # what a format has no place for


@pytest.mark.parametrize("suffix", list(marked(READING, READABLE)))
def test_what_is_written_is_read_back(tmp_path, suffix):
    animation = line_for(suffix, fps=30.0 if suffix == ".vmd" else 30000 / 1001)
    path = tmp_path / f"a{suffix}"
    save(animation, path, **OPTIONS.get(suffix, {}))
    again = load(path)
    kept = [name for name in animation.channels if name not in STILL.get(suffix, ())]
    assert set(kept) <= set(again.channels)
    assert again.fps == pytest.approx(animation.fps, rel=1e-5)
    for name in kept:
        curve = animation.channel(name)
        np.testing.assert_allclose(again.channel(name), curve, rtol=0, atol=DIGITS.get(suffix, 0))


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".json", ".npz", ".vrma"])
def test_labels_and_provenance_are_kept(tmp_path, suffix):
    animation = replace(line(), start=0.25, audio=tmp_path / "hello.wav")
    save(animation, tmp_path / f"a{suffix}")
    again = load(tmp_path / f"a{suffix}")
    for name in ("channels", "fps", "rig", "start", "phones", "words", "audio", "provenance"):
        assert getattr(again, name) == getattr(animation, name), name


@pytest.mark.parametrize("suffix", WRITABLE)
def test_the_same_animation_gives_the_same_bytes(tmp_path, suffix, written):
    first = written(suffix).read_bytes()
    assert written(suffix).read_bytes() == first
    assert first


@pytest.fixture
def written(tmp_path):
    def write(suffix):
        path = tmp_path / f"hello{suffix}"
        save(line_for(suffix), path, **OPTIONS.get(suffix, {}))
        return path

    return write


@pytest.mark.parametrize("suffix", WRITABLE)
def test_destinations_that_cannot_be_written(tmp_path, suffix):
    with pytest.raises(OutputError, match=r"the folder .*nowhere does not exist; create it first"):
        save(line_for(suffix), tmp_path / "nowhere" / f"a{suffix}", **OPTIONS.get(suffix, {}))
    (tmp_path / f"a{suffix}").mkdir()
    with pytest.raises(OutputError, match=r"is a folder; name a file in it"):
        save(line_for(suffix), tmp_path / f"a{suffix}", **OPTIONS.get(suffix, {}))
    assert [path.name for path in tmp_path.iterdir()] == [f"a{suffix}"]


@pytest.mark.skipif(
    not Path("/dev/full").exists() or os.name != "posix", reason="needs a device that is full"
)
@pytest.mark.parametrize("suffix", [item for item in WRITABLE if item.values != (".mp4",)])
def test_a_full_disk_leaves_the_old_file(tmp_path, suffix, monkeypatch):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"old")

    def full(self, data):
        with Path("/dev/full").open("wb", buffering=0) as stream:
            return stream.write(data)

    monkeypatch.setattr(Path, "write_bytes", full)
    opened = Path.open
    device = Path("/dev/full")
    monkeypatch.setattr(
        Path, "open", lambda self, mode="r", **o: opened(device if "w" in mode else self, mode, **o)
    )
    with pytest.raises(OutputError, match=r"cannot be written: No space left on device"):
        save(line_for(suffix), path, **OPTIONS.get(suffix, {}))
    assert path.read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == 1


def test_animations_that_are_not_written(tmp_path):
    animation = line()
    values = animation.values.copy()
    values[3, 7] = np.nan
    message = rf"{animation.channels[7]} is not a finite number at 0\.050 s; correct the curve first"
    with pytest.raises(OutputError, match=message):
        save(animation.with_values(values), tmp_path / "a.csv")
    with pytest.raises(OutputError, match=r"the animation has no frames or no channels"):
        save(animation.with_values(values[:0]), tmp_path / "a.csv")
    assert not list(tmp_path.iterdir())


def test_files_that_are_no_archives_of_arrays(tmp_path):
    path = tmp_path / "a.npz"
    stream = BytesIO()
    np.save(stream, np.zeros(3))
    for content in (b"", b"PK", stream.getvalue()):
        path.write_bytes(content)
        with pytest.raises(OutputError, match=r"a\.npz: is not an animation written by phonanim: "):
            load(path)


def test_npz_carries_what_the_mouth_does(tmp_path):
    plain = line()
    mouth = np.arange(len(plain.values) * len(CHANNELS), dtype=np.float32).reshape(len(plain.values), -1)
    save(replace(plain, articulation=mouth), tmp_path / "a.npz")
    again = load(tmp_path / "a.npz")
    np.testing.assert_array_equal(again.articulation, mouth)
    assert again.at_rate(plain.fps / 2).articulation.shape[1] == len(CHANNELS)
    save(replace(plain, articulation=mouth[:, :3]), tmp_path / "b.npz")
    with pytest.raises(OutputError, match=r"its articulation is not \d+ frames of 10 finite channels"):
        load(tmp_path / "b.npz")


LEFT = np.float32(0.4375)  # no other weight is this
DAMAGE = {
    "a.npz": lambda path, animation: save_arrays(
        path, {"values": animation.values, "channels": np.array(animation.channels), "about": about(path)}
    ),
    "a.json": lambda path, _: path.write_text(
        re.sub(r'"jawOpen":\[[^,]*', '"jawOpen":[NaN', path.read_text())
    ),
    "a.track.json": lambda path, _: path.write_text(
        re.sub(r"(\[\s*0.0,\s*)[\d.]+", r"\1NaN", path.read_text())
    ),
    "a.glb": lambda path, animation: path.write_bytes(
        path.read_bytes().replace(LEFT.tobytes(), np.float32(np.nan).tobytes())
    ),
    "a.csv": lambda path, _: path.write_text(path.read_text().replace("0.4375000000", "nan")),
    "a.usda": lambda path, _: path.write_text(re.sub(r" 0\.4375,", " nan,", path.read_text())),
}


def about(path):
    with np.load(path) as archive:
        return archive["about"]


@pytest.mark.parametrize("name", DAMAGE)
def test_curves_that_are_not_finite_are_not_read(tmp_path, name):
    if name == "a.usda":
        pytest.importorskip("pxr", reason="needs the extra usd")
    animation = line()
    animation.values[3, animation.channels.index("jawOpen")] = LEFT
    save(animation, tmp_path / name)
    animation.values[3, animation.channels.index("jawOpen")] = np.nan
    DAMAGE[name](tmp_path / name, animation)
    with pytest.raises(
        OutputError, match=r"(is not a finite number at .*; correct the curve first|finite numbers|has NaN)"
    ):
        load(tmp_path / name)
    with pytest.raises(OutputError, match=rf"{re.escape(name)}"):
        load(tmp_path / name)


@pytest.mark.skipif(find_spec("pxr") is not None, reason="the extra usd is installed")
def test_a_missing_extra_is_named(tmp_path):
    with pytest.raises(
        MissingExtraError, match=r"binary USD needs the USD library: pip install 'phonanim\[usd\]'"
    ):
        save(line(), tmp_path / "a.usdc")
    assert not list(tmp_path.iterdir())


def test_options_that_a_format_does_not_have(tmp_path):
    assert option_names(Path("a.glb")) == ("character", "keys")
    with pytest.raises(OutputError, match=r"a\.csv: this format has no option keys; those it has: timecode"):
        save(line(), tmp_path / "a.csv", keys=0.01)
    with pytest.raises(OutputError, match=r"a\.npz: this format has no option x; those it has: none"):
        save(line(), tmp_path / "a.npz", x=1)


@pytest.mark.parametrize("suffix", [".json", ".npz"])
def test_files_that_are_not_ours(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    with pytest.raises(OutputError, match=r"cannot be read|is not an animation written by phonanim"):
        load(path)
    path.write_bytes(b"{}")
    with pytest.raises(
        OutputError,
        match=r"is not an animation written by phonanim: (it lacks 'curves'|it is not an archive)",
    ):
        load(path)


def test_json_of_another_format(tmp_path):
    save(line(), tmp_path / "a.json")
    tree = json.loads((tmp_path / "a.json").read_text())
    (tmp_path / "a.json").write_text(json.dumps({**tree, "format": "phonanim animation 9"}))
    with pytest.raises(
        OutputError, match=r"its format is 'phonanim animation 9', not 'phonanim animation 1'"
    ):
        load(tmp_path / "a.json")
    (tmp_path / "a.json").write_text("[")
    with pytest.raises(OutputError, match=r"a\.json: cannot be read as JSON"):
        load(tmp_path / "a.json")


def test_json_is_written_curve_by_curve_as_a_whole(tmp_path):
    take = line(frames=7)
    save(take, tmp_path / "a.json")
    whole = json.dumps(document(take), ensure_ascii=False, separators=(",", ":")) + "\n"
    assert (tmp_path / "a.json").read_text("utf-8") == whole
