"""Takes that nobody means to write: each is refused in one line that names the file."""

import json

import numpy as np
import pytest
from animations import line

from phonanim.errors import PhonanimError
from phonanim.exporters import load, save

BAD_NUMBERS = (-1, 0, float("nan"), float("inf"), 1e300, "30", None, [], {}, True, 10**400)
AUDIO = ("http://127.0.0.1:1/a.wav", "../x.wav", "/etc/passwd", 3, ["a.wav"], "a\0b")


def json_take(path, **changes):
    save(line(), path)
    tree = json.loads(path.read_text())
    path.write_text(json.dumps({**tree, **changes}))


def npz_take(path, **changes):
    save(line(), path)
    with np.load(path) as archive:
        arrays = dict(archive)
    arrays["about"] = np.array(json.dumps({**json.loads(str(arrays["about"])), **changes}))
    np.savez(path, **arrays)


def glb_take(path, **changes):
    from phonanim.media.glb import glb_bytes, read_glb

    save(line(), path)
    glb = read_glb(path)
    glb.tree["animations"][-1]["extras"] |= changes
    path.write_bytes(glb_bytes(json.loads(json.dumps(glb.tree).replace("Infinity", "1e999")), glb.binary))


WRITERS = {"a.json": json_take, "a.npz": npz_take, "a.glb": glb_take}
FINITE = [value for value in BAD_NUMBERS if value == value and value != float("inf")]


def refused(path):
    with pytest.raises(PhonanimError) as caught:
        load(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("name", WRITERS)
def test_frame_rates_and_starts(tmp_path, name):
    for value in FINITE if name == "a.glb" else BAD_NUMBERS:
        WRITERS[name](tmp_path / name, fps=value)
        refused(tmp_path / name)
        if value not in (-1, 0) or value is True:
            WRITERS[name](tmp_path / name, start=value)
            refused(tmp_path / name)


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("audio", AUDIO)
def test_the_sound_is_a_plain_name_beside_the_take(tmp_path, name, audio):
    WRITERS[name](tmp_path / name, audio=audio)
    assert "it is the plain name of a file beside this one" in refused(tmp_path / name)
    WRITERS[name](tmp_path / name, audio="line.wav")
    assert load(tmp_path / name).audio == tmp_path / "line.wav"


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize(
    "changes",
    [
        {"phones": [["a", 0, 1e300]]},
        {"phones": [["a", 0]]},
        {"phones": [[{}, 0, 1]]},
        {"words": 3},
        {"rig": []},
        {"provenance": "me"},
    ],
)
def test_what_stands_beside_the_curves(tmp_path, name, changes):
    WRITERS[name](tmp_path / name, **changes)
    refused(tmp_path / name)


@pytest.mark.parametrize(
    "curves",
    [[], {"a": [1], "b": [1, 2]}, {"a": "no"}, {"a": [[1]]}, {"a": [10**400]}, {"a": [{}]}, {}, None],
)
def test_curves_that_are_none(tmp_path, curves):
    json_take(tmp_path / "a.json", curves=curves)
    refused(tmp_path / "a.json")


@pytest.mark.parametrize(
    "changes",
    [
        {"values": np.zeros((3, 2))},
        {"values": np.array(["a"])},
        {"values": np.zeros((3, 52), "c8")},
        {"channels": np.array([["a"]])},
        {"channels": np.arange(52)},
        {"channels": np.array(["jawOpen"] * 52)},
    ],
)
def test_arrays_that_do_not_fit(tmp_path, changes):
    save(line(), tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as archive:
        arrays = dict(archive)
    np.savez(tmp_path / "a.npz", **arrays | changes)
    refused(tmp_path / "a.npz")


@pytest.mark.parametrize(
    "keys",
    [
        [],
        [[1e12, 0]],
        [[0, 0], [1e6, 1]],
        [[1, 0], [0, 0]],
        [[float("nan"), 0]],
        [["a", 0]],
        [[0, 0, 0]],
        [[1e300, 1]],
    ],
)
def test_keys_of_tracks(tmp_path, keys):
    tree = {"format": "openfacefx.track", "version": 1, "fps": 240, "channels": [{"name": "a", "keys": keys}]}
    (tmp_path / "a.track.json").write_text(json.dumps(tree))
    refused(tmp_path / "a.track.json")
    (tmp_path / "a.track.json").write_text(json.dumps({**tree, "channels": 3}))
    refused(tmp_path / "a.track.json")


@pytest.mark.parametrize(
    "rows",
    [
        ["00:00:00:00,1,0", "00:00:00:00.001,1,0", "23:59:59:59,1,0", "23:59:59:59.001,1,0"],
        ["00:00:00:00,1,nan", "00:00:00:01,1,0"],
        ["00:00:00:00,1", "00:00:00:01,1,0"],
        ["99:00:00:00"],
        [],
    ],
)
def test_rows_of_recordings(tmp_path, rows):
    (tmp_path / "a.csv").write_text("\n".join(["Timecode,BlendShapeCount,JawOpen", *rows]) + "\n")
    with pytest.raises(PhonanimError, match=r"a\.csv"):
        load(tmp_path / "a.csv")


def test_recordings_whose_channels_share_a_name(tmp_path):
    (tmp_path / "a.csv").write_text(
        "Timecode,BlendShapeCount,JawOpen,jawOpen\n00:00:00:00,2,0,0\n00:00:00:01,2,0,0\n"
    )
    assert "two of its channels are called 'jawOpen'" in refused(tmp_path / "a.csv")


def test_depth_bombs(tmp_path):
    for name in ("a.json", "a.track.json"):
        (tmp_path / name).write_text("[" * 100_000)
        assert "nested deeper than 64 levels" in refused(tmp_path / name)


def test_pipes_and_devices_are_refused(tmp_path):
    for name in ("a.json", "a.csv", "a.npz", "a.track.json", "a.glb"):
        (tmp_path / name).symlink_to("/dev/zero")
        assert "it is a pipe or a device" in refused(tmp_path / name)
