"""`phonanim animate` as it is used, and what it says of bad input."""

import json
import shutil
import subprocess
import sys

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

HEADER = 'File type = "ooTextFile"\nObject class = "TextGrid"\n\n'


@pytest.fixture
def line(root, tmp_path, monkeypatch):
    """The example line in a folder of its own, which is the current one."""
    for suffix in (".TextGrid", ".wav"):
        shutil.copy(root / "examples" / f"line{suffix}", tmp_path / f"a{suffix}")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(root))
    return tmp_path


def files(folder):
    return sorted(path.name for path in folder.iterdir())


def complaint(capsys):
    """The one line on stderr."""
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1, err
    assert "Traceback" not in err
    return err


def test_nothing_but_an_alignment(line, capsys):
    assert run(["animate", "a.TextGrid"]) == 0
    assert files(line) == ["a.TextGrid", "a.glb", "a.wav"]
    out, err = capsys.readouterr()
    assert out == ""
    told = err.splitlines()
    assert len(told) == 5
    assert told[4] == "to see it: --view, or open a.glb in any glTF viewer"
    assert told[0] == "read a.TextGrid: 39 phones in 4.52 s with a.wav"
    assert told[1] == "language english, by its labels, 99 % sure"
    assert told[2] == "moved arkit_tongue by default: 272 frames at 60 fps, 60 channels"
    assert told[3].startswith("wrote a.glb (")


def test_another_reader_takes_the_glb(line):
    pygltflib = pytest.importorskip("pygltflib")
    assert run(["animate", "a.TextGrid", "-q"]) == 0
    tree = pygltflib.GLTF2().load("a.glb")
    (mesh,) = [mesh for mesh in tree.meshes if mesh.weights]
    assert len(mesh.weights) == len(mesh.extras["targetNames"])
    assert {"jawOpen", "mouthClose"} <= set(mesh.extras["targetNames"])
    (animation,) = tree.animations
    times = tree.accessors[animation.samplers[0].input]
    assert times.min == [0.0]
    assert times.max == pytest.approx([271 / 60])


def test_live_link_at_25(line, capsys):
    assert run(["animate", "a.TextGrid", "-o", "a.csv", "--rig", "arkit", "--fps", "25"]) == 0
    rows = (line / "a.csv").read_text().splitlines()
    assert rows[0].split(",")[:2] == ["Timecode", "BlendShapeCount"]
    assert len(rows) == 1 + 114  # the instants from 0 to 4.520937 s
    assert "moved arkit by default: 114 frames at 25 fps" in capsys.readouterr().err


def test_several_outputs_and_a_sheet(line):
    assert run(["animate", "a.TextGrid", "-o", "a.glb", "-o", "a.npz", "--contact-sheet", "a.png", "-q"]) == 0
    assert files(line) == ["a.TextGrid", "a.glb", "a.npz", "a.png", "a.wav"]
    assert (line / "a.png").read_bytes().startswith(b"\x89PNG")


def test_gains_of_single_controls(line, capsys):
    assert run(["animate", "a.TextGrid", "-o", "a.json", "-q"]) == 0
    assert (
        run(
            [
                "animate",
                "a.TextGrid",
                "-o",
                "b.json",
                "--gain",
                "mouthPucker=0.5",
                "--gain",
                "jawOpen=0",
                "-q",
            ]
        )
        == 0
    )
    before, after = (json.loads((line / name).read_text())["curves"] for name in ("a.json", "b.json"))
    assert max(before["jawOpen"]) > 0.05
    assert not any(after["jawOpen"])
    np.testing.assert_allclose(after["mouthPucker"], np.multiply(before["mouthPucker"], 0.5), atol=2e-6)


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        (["jawOpen"], "'jawOpen' is not CONTROL=NUMBER, such as jawOpen=1.2"),
        (["jawOpen=nan"], "jawOpen = 'nan'; give a number from 0 to 4"),
        (["jawOpen=1", "jawOpen=2"], "jawOpen has two gains; give it one"),
        (["jawOpn=1"], "gain jawOpn=1: arkit has no such control; did you mean jawOpen?"),
    ],
)
def test_gains_that_make_no_sense(line, capsys, gains, message):
    assert (
        run(["animate", "a.TextGrid", "-o", "a.csv", *(word for gain in gains for word in ("--gain", gain))])
        == 2
    )
    assert message in complaint(capsys)
    assert not (line / "a.csv").exists()


def test_quiet_and_json(line, capsys):
    assert run(["animate", "a.TextGrid", "-o", "a.csv", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    assert run(["animate", "a.TextGrid", "-o", "a.csv", "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    facts = json.loads(out)
    assert facts["frames"] == 272
    assert facts["outputs"] == [{"path": "a.csv", "bytes": (line / "a.csv").stat().st_size}]


def test_the_same_input_gives_the_same_bytes(line):
    outputs = ["-o", "a.csv", "-o", "a.glb", "-o", "a.npz", "-o", "a.json"]
    assert run(["animate", "a.TextGrid", *outputs, "-q"]) == 0
    first = {path.name: path.read_bytes() for path in line.iterdir()}
    command = [sys.executable, "-m", "phonanim", "animate", "a.TextGrid", *outputs, "-q"]
    subprocess.run(command, check=True, cwd=line)
    assert {path.name: path.read_bytes() for path in line.iterdir()} == first


@pytest.mark.parametrize("rate", ["24", "25", "30000/1001", "30", "48", "50", "120"])
def test_frame_rates_agree_at_shared_instants(line, rate):
    run(["animate", "a.TextGrid", "-o", "slow.npz", "--fps", rate, "-q", "--no-contacts"])
    run(["animate", "a.TextGrid", "-o", "fast.npz", "--fps", "600", "-q", "--no-contacts"])
    fast, slow = np.load("fast.npz"), np.load("slow.npz")
    numbers = slow["times"] * 600
    shared = np.abs(numbers - np.rint(numbers)) < 1e-6
    assert shared.sum() >= 3
    same = fast["values"][np.rint(numbers[shared]).astype(int)]
    np.testing.assert_allclose(slow["values"][shared], same, atol=1e-4)


def test_dials(line):
    for name, options in {"one": [], "still": ["--intensity", "0"], "loud": ["--jaw", "1.5"]}.items():
        assert run(["animate", "a.TextGrid", "-o", f"{name}.npz", "-q", "--life", "0", *options]) == 0
    one, still, loud = (np.load(f"{name}.npz")["values"] for name in ("one", "still", "loud"))
    channels = list(np.load("one.npz")["channels"])
    assert np.ptp(still, axis=0).max() == 0
    jaw = channels.index("jawOpen")
    assert (loud[:, jaw] >= one[:, jaw] - 1e-6).all()
    assert 1.3 < loud[:, jaw].max() / one[:, jaw].max() <= 1.5


def test_layers(line):
    layers = ["--overlay", "smile=0.5@1-2", "--overlay", "angry", "--blinks", "7", "--smooth", "8Hz"]
    assert run(["animate", "a.TextGrid", "-o", "a.npz", "-q", *layers]) == 0
    about = json.loads(str(np.load("a.npz")["about"]))["provenance"]
    assert about["options"]["overlays"] == [
        {"source": "smile", "gain": 0.5, "span": [1.0, 2.0]},
        {"source": "angry", "gain": 1.0, "span": None},
    ]
    assert (about["options"]["blinks"], len(about["overlays_sha256"])) == (7, 2)
    assert about["options"]["smooth"] == pytest.approx(0.039, abs=0.001)


def test_labels_nobody_knows(line, capsys):
    phones = [Interval("AA", 0.0, 0.5), Interval("QQQ", 0.5, 1.0)]
    write_textgrid(line / "b.TextGrid", {"phones": phones}, 1.0)
    assert run(["animate", "b.TextGrid", "--language", "english"]) == 2
    said = complaint(capsys)
    assert "QQQ" in said
    assert "0.5" in said
    assert files(line) == ["a.TextGrid", "a.wav", "b.TextGrid"]
    assert run(["animate", "b.TextGrid", "--language", "english", "--on-unknown-label", "silence"]) == 0
    assert "QQQ" in capsys.readouterr().err


GOOD_TIER = (
    'xmin = 0\nxmax = 1\ntiers? <exists>\nsize = 1\nitem []:\n    item [1]:\n        class = "IntervalTier"\n'
)
INTERVAL = '        intervals [{}]:\n            xmin = {}\n            xmax = {}\n            text = "{}"\n'


def grid(*intervals, name="phones"):
    body = "".join(INTERVAL.format(number, *interval) for number, interval in enumerate(intervals, start=1))
    tier = f'        name = "{name}"\n        xmin = 0\n        xmax = 1\n'
    return (HEADER + GOOD_TIER + tier + f"        intervals: size = {len(intervals)}\n" + body).encode()


@pytest.mark.parametrize(
    "content",
    {
        "empty": b"",
        "binary": bytes(range(256)) * 8,
        "no tier": (HEADER + "xmin = 0\nxmax = 1\ntiers? <exists>\nsize = 0\nitem []:\n").encode(),
        "words only": grid((0, 1, "\u0434\u0430"), name="words"),
        "overlap": grid((0, 0.6, "AA"), (0.2, 1, "B")),
        "reversed": grid((0.6, 0.2, "AA"), (0.6, 1, "B")),
        "not a time": grid((0, "nan", "AA"), (0.5, 1, "B")),
        "endless": grid((0, "inf", "AA")),
        "six hours": grid((0, 21600, "AA")),
        "cut short": grid((0, 0.5, "AA"), (0.5, 1, "B"))[:-60],
    }.items(),
    ids=lambda item: item[0],
)
def test_bad_alignments_are_one_line_and_nothing_is_written(content, line, capsys):
    (line / "b.TextGrid").write_bytes(content[1])
    assert run(["animate", "b.TextGrid", "-o", "b.csv"]) == 2
    assert "b.TextGrid" in complaint(capsys)
    assert files(line) == ["a.TextGrid", "a.wav", "b.TextGrid"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["-o", "a.xyz"], "a.xyz"),
        (["-o", "b.csv", "-o", "a"], "phonanim: a: "),
        (["-o", "missing/a.csv"], "the folder"),
        (["-o", "/proc/a.csv"], "/proc/a.csv: cannot be written"),
        (["-o", "a.TextGrid"], "is named twice"),
        (["-o", "b.csv", "-o", "./b.csv"], "b.csv: is named twice"),
        (["--model", "defualt"], "there is no model 'defualt'; did you mean 'default'?"),
        (["--rig", "arkt"], "arkit"),
        (["--language", "englisch"], "english"),
        (["--tier", "sounds"], "phones"),
        (["--fps", "fast"], "'fast' is not a frame rate"),
        (["--fps", "0"], "must lie from 1 to 1000"),
        (["--jaw", "nan"], "nan is not in the range 0<=x<=4"),
        (["--smooth", "fast"], "'fast' is neither 0 to 1 seconds nor a rate such as 8Hz"),
        (["--smooth", "2"], "'2' is neither 0 to 1 seconds"),
        (["--smooth", "0Hz"], "'0Hz' is neither 0 to 1 seconds"),
        (["--overlay", ""], "names no file; write FILE=GAIN@START-END, such as smile=0.5@1.2-3"),
        (["--overlay", "smile=0.5@3-2"], "smile=0.5@3-2: its span must end after it starts, such as @1.2-3"),
        (["--overlay", "smile=5"], "give a number from 0 to 4"),
        (["--overlay", "smil"], "overlay smil: there is no such file or pose; did you mean smile?"),
        (["--blinks", "-1"], "-1 is not in the range x>=0"),
        (["--audio", "missing.wav"], "missing.wav"),
    ],
)
def test_bad_options_are_one_line_and_nothing_is_written(options, said, line, capsys):
    assert run(["animate", "a.TextGrid", *options]) == 2
    assert said in complaint(capsys)
    assert files(line) == ["a.TextGrid", "a.wav"]


@pytest.mark.parametrize("damage", ["model.json", "weights.safetensors", "face.safetensors"])
@pytest.mark.parametrize("how", ["gone", "empty", "cut", "noise"])
def test_damaged_models(damage, how, line, root, capsys):
    shutil.copytree(root / "phonanim" / "models" / "default", line / "mine")
    path = line / "mine" / damage
    whole = path.read_bytes()
    path.write_bytes({"empty": b"", "cut": whole[: len(whole) // 2], "noise": whole[::-1]}.get(how, b""))
    if how == "gone":
        path.unlink()
    assert run(["animate", "a.TextGrid", "--model", "mine"]) == 2
    assert "mine" in complaint(capsys)
    assert files(line) == ["a.TextGrid", "a.wav", "mine"]


@pytest.mark.parametrize("suffix", ["csv", "glb", "npz", "json", "png"])
def test_a_disk_that_fills_up(suffix, line):
    """A limit on the size of files stands in for a full disk: the write fails half-way."""
    code = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)); "
        "from phonanim.__main__ import run; sys.exit(run(sys.argv[1:]))"
    )
    where = ["-o", "b.csv", "--contact-sheet", "b.png"] if suffix == "png" else ["-o", f"b.{suffix}"]
    command = [sys.executable, "-c", code, "animate", "a.TextGrid", *where]
    done = subprocess.run(command, cwd=line, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr == f"phonanim: b.{suffix}: cannot be written: File too large\n"
    assert files(line) == ["a.TextGrid", "a.wav"]


def test_what_was_there_stays_when_the_new_one_fails(line, capsys):
    (line / "b.csv").write_text("old")
    (line / "b.TextGrid").write_bytes(b"")
    assert run(["animate", "b.TextGrid", "-o", "b.csv"]) == 2
    assert (line / "b.csv").read_text() == "old"


def test_from_speech_and_text(line, capsys):
    pytest.importorskip("pocketsphinx")
    text = "My father watched Bob move a cheap blue lamp from the wash room."
    assert run(["animate", "a.wav", "--text", text]) == 2
    assert "a.TextGrid: already exists; animate it, or remove it" in complaint(capsys)
    (line / "a.TextGrid").unlink()
    assert run(["animate", "a.wav", "--text", text]) == 0
    assert files(line) == ["a.TextGrid", "a.glb", "a.wav"]
    assert "39 phones in 4.52 s with a.wav" in capsys.readouterr().err
