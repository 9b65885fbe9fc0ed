import json
from dataclasses import replace

import numpy as np
import pytest
from animations import line

from phonanim.errors import OutputError
from phonanim.exporters import load, save
from phonanim.rig.neck import TURNS

EXPORT = {
    "exportFps": 30.0,
    "trackPath": "C:\\sounds\\line.wav",
    "numPoses": 2,
    "numFrames": 3,
    "facsNames": ["jawOpen", "mouthClose"],
    "weightMat": [[0, 0.5], [1, 0.25], [0.5, 0]],
    "joints": [],
}


@pytest.fixture
def export(tmp_path):
    def write(name="a.a2f.json", **changes):
        tree = {key: value for key, value in {**EXPORT, **changes}.items() if value is not None}
        (tmp_path / name).write_text(json.dumps(tree))
        return tmp_path / name

    return write


def test_what_is_written(tmp_path):
    save(replace(line(fps=30), audio=tmp_path / "hello.wav"), tmp_path / "a.a2f.json")
    tree = json.loads((tmp_path / "a.a2f.json").read_text())
    assert (tree["exportFps"], tree["numPoses"], tree["numFrames"]) == (30, 52, 61)
    assert isinstance(tree["exportFps"], int)
    assert tree["trackPath"] == "hello.wav"
    assert tree["facsNames"] == [name for name in line().channels if name not in TURNS]
    assert np.shape(tree["weightMat"]) == (61, 52)


@pytest.mark.parametrize("name", ["a.a2f.json", "a.json"])
def test_exports_are_read_by_what_is_in_them(export, name):
    found = load(export(name))
    assert (found.channels, found.fps, found.start) == (("jawOpen", "mouthClose"), 30, 0)
    assert found.values.tolist() == EXPORT["weightMat"]
    assert load(export(name, exportFps=None)).fps == 60


def test_frames_begin_at_time_zero(tmp_path):
    save(replace(line(), start=0.1), tmp_path / "a.a2f.json")
    found = load(tmp_path / "a.a2f.json")
    assert len(found.values) == 61 + 6
    assert found.channel("jawOpen")[6] == pytest.approx(line().channel("jawOpen")[0], abs=1e-6)


@pytest.mark.parametrize("name", ["a.a2f.json", "a.json"])
@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"weightMat": [[0, 0], [1]]}, r"weightMat\[1\] has 1 weights for 2 names"),
        ({"weightMat": 3}, r"weightMat is 3; it is a list"),
        ({"weightMat": [["a", 1]]}, ""),
        ({"facsNames": ["a", "a"]}, "two of its channels are called 'a'"),
        ({"facsNames": [1, 2]}, "a name in facsNames is 1; it is a text"),
        ({"exportFps": 0}, "exportFps is 0"),
    ],
)
def test_exports_that_are_damaged(export, name, changes, reason):
    with pytest.raises(OutputError, match=rf"{name}: is not an export of Audio2Face: {reason}"):
        load(export(name, **changes))


def test_other_json(export):
    with pytest.raises(OutputError, match=r"is not an export of Audio2Face: it lacks 'weightMat'"):
        load(export(weightMat=None))
