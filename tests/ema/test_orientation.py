"""Axes of files are found by where lips and tongue lie, and a folder of a machine's own files is built."""

from __future__ import annotations

import json
from itertools import permutations
from pathlib import Path

import ema_samples as samples
import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.corpus.motion import load_motion_corpus
from phonanim.ema.articulation import orient_axes
from phonanim.ema.orientation import find_axes

MOUTH = ((0.0, 0.0, 0.0), (45.0, 0.0, 8.0), (43.0, 0.0, -10.0))  # dorsum and lips: forward, left, up
SIGNS = (("forward", "back"), ("left", "right"), ("up", "down"))
CHANNELS = "NA,EL,ER,TD,UL,LL,-"
SKULL = ((60.0, 0.0, 50.0), (-40.0, 70.0, 30.0), (-40.0, -70.0, 30.0))


def right_handed() -> list[str]:
    """All 24 ways in which a file's axes may point."""
    found = []
    for order in permutations(range(3)):
        for bits in range(8):
            signs = [1 - 2 * (bits >> place & 1) for place in range(3)]
            turned = np.zeros((3, 3))
            turned[list(range(3)), list(order)] = signs
            if np.linalg.det(turned) > 0:
                found.append(",".join(SIGNS[axis][sign < 0] for axis, sign in zip(order, signs, strict=True)))
    return found


@pytest.mark.parametrize("axes", right_handed())
def test_every_way_is_found(axes: str) -> None:
    mouth = samples.still(*MOUTH, names="TD UL LL")
    shown = orient_axes(mouth, "forward,left,up").positions[0]
    own = np.stack(
        [
            sign * shown[:, axis]
            for axis, sign in (_direction(word) for word in axes.split(","))
        ],
        axis=1,
    )  # fmt: skip
    written = samples.still(*map(tuple, own), names="t_back upper_lip lower_lip")
    assert find_axes([written]) == axes
    assert orient_axes(written, axes).positions[0] == pytest.approx(shown)


def _direction(word: str) -> tuple[int, float]:
    axis = next(place for place, pair in enumerate(SIGNS) if word in pair)
    return axis, 1.0 if SIGNS[axis][0] == word else -1.0


@pytest.mark.parametrize(
    ("points", "names"),
    [
        (MOUTH[1:], "UL LL"),  # no tongue
        (((0.0, 0.0, 0.0), (45.0, 0.0, 1.0), (45.0, 0.0, 0.0)), "TD UL LL"),  # lips that are one
        (((0.0, 0.0, 0.0), (45.0, 0.0, 10.0), (36.0, 0.0, 0.0)), "TD UL LL"),  # a head bent by 42 degrees
        (((0.0, 0.0, 30.0), (1.0, 0.0, 10.0), (0.0, 0.0, -10.0)), "TD UL LL"),  # a tongue above the lips
    ],
)
def test_what_does_not_show_them(points: tuple[tuple[float, float, float], ...], names: str) -> None:
    assert find_axes([samples.still(*points, names=names)]) is None


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Recordings of a Carstens machine whose x is left, and y is back; the head drifts, the lips open."""
    made = tmp_path / "pos"
    made.mkdir()
    times = np.arange(250) / 250
    for number in (1, 2):
        places = np.zeros((250, 7, 3))
        places[:, :6] = np.array([*SKULL, *MOUTH])[:, [1, 0, 2]] * (1, -1, 1)
        places[:, 5, 2] -= 4 * np.sin(2 * np.pi * 4 * times) ** 2
        places[:, :6] += times[:, None, None] * 10
        samples.pos(made / f"{number}.pos", places)
        phones = ((0.0, 0.2, "sil"), (0.2, 0.5, "t"), (0.5, 0.8, "iy"), (0.8, 1.0, "sil"))
        samples.textgrid(made / f"{number}.TextGrid", *phones)
    return made


def test_a_folder_of_a_machine(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "names.txt").write_text(CHANNELS.replace(",", "\n"), "utf-8")
    given = ["corpus", "build", str(folder), "--language", "english", "--reference", "NA,EL,ER"]
    for name, names in (("a", CHANNELS), ("b", str(tmp_path / "names.txt"))):
        assert run([*given, "-o", str(tmp_path / name), "--names", names]) == 0
        told = capsys.readouterr().err
        assert "x, y and z are left,back,up, as lips and tongue lie" in told
        assert "splits: 2 train" in told
    corpus = load_motion_corpus(tmp_path / "a")
    assert corpus.source.names == ("TD", "UL", "LL")
    frames = np.asarray(corpus.frames(0))
    assert np.ptp(frames[:, :2], axis=0).max() < 0.01  # the head is still
    assert np.ptp(frames[:, 2], axis=0) == pytest.approx([0, 0, 4], abs=0.3)
    assert (frames[:, 1] - frames[:, 0])[0] == pytest.approx(MOUTH[1], abs=0.1)
    index = [(tmp_path / name / "corpus.json").read_text("utf-8") for name in "ab"]
    assert index[0] == index[1]


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--names", "A,B"], "2 names for the 7 sensors"),
        ([], "no sensor in common; name them with --names"),
        (["--names", CHANNELS, "--reference", "NA,EL"], "2 reference sensors do not fix the head"),
        (["--names", CHANNELS, "--axes", "left,up"], "give the directions of x, y and z"),
        (["--names", CHANNELS, "--template", "."], "--template: is for vertices, and these are sensors"),
        (["--names", CHANNELS, "--every", "2"], "--rate sets the rate of sensors"),
        (["--names", CHANNELS, "--bite-plate", "1.pos"], "--bite-plate needs --reference"),
    ],
)
def test_what_does_not_fit(
    options: list[str],
    told: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(folder)
    assert run(["corpus", "build", ".", "-o", "../out", *options]) == 2
    assert told in capsys.readouterr().err


def test_names_that_are_no_text(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "names.txt").write_bytes(b"\xff\xfe\xff")
    given = ["corpus", "build", str(folder), "-o", str(tmp_path / "out")]
    assert run([*given, "--names", str(tmp_path / "names.txt")]) == 2
    assert "names.txt: cannot be read" in capsys.readouterr().err


def test_arrays_of_sensors_say_their_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.savez(tmp_path / "one.npz", sensors=("UL", "LL"), xyz=np.zeros((140, 2, 3)), hz=100)
    assert run(["corpus", "build", str(tmp_path), "-o", str(tmp_path / "c"), "--axes", "left,back,up"]) == 2
    assert "an .npz of sensors has names, and axes forward, left and up" in capsys.readouterr().err


def test_a_set_without_a_split_gets_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As those of controls and vertices: every tenth recording is a test."""
    (tmp_path / "motion").mkdir()
    rows = ["name,speaker,split,frames,fps,seconds,text,emotion"]
    for number in range(10):
        np.save(tmp_path / "motion" / f"{number}.npy", np.tile(np.array(MOUTH, np.float32), (60, 1, 1)))
        rows.append(f"{number},a,,60,50,1.2,,")
    (tmp_path / "recordings.csv").write_text("\n".join(rows) + "\n", "utf-8")
    facts = {"name": "own", "kind": "sensors", "names": ["TD", "UL", "LL"], "unit": "mm", "fps": 50}
    (tmp_path / "dataset.json").write_text(json.dumps(facts), "utf-8")
    assert run(["corpus", "build", str(tmp_path), "-o", str(tmp_path / "c")]) == 0
    told = capsys.readouterr().err
    assert "splits: 9 train, 1 test" in told
    assert "the data set has no split: every tenth recording is a test" in told
